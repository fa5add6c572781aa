// Undoes tools/sigmafmu/view/packed.py: base64, deflate, byte streams, differences, bias and step.

export async function unpack(text) {
  const compressed = Uint8Array.from(atob(text.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([compressed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// The columns of a ticket, each a Float64Array.
export function columns(bytes, { at, n, bias, step }) {
  const count = n * bias.length;
  return bias.map((low, column) => {
    const values = new Float64Array(n);
    let whole = 0;
    for (let i = 0; i < n; i++) {
      const k = at + column * n + i;
      const zigzag = bytes[k] | (bytes[k + count] << 8) | (bytes[k + 2 * count] << 16) | (bytes[k + 3 * count] << 24);
      whole += (zigzag >>> 1) ^ -(zigzag & 1);
      values[i] = low + step[column] * whole;
    }
    return values;
  });
}

// The same, row after row, in an array of another type.
export function rows(bytes, ticket, Type) {
  const all = columns(bytes, ticket);
  const result = new Type(ticket.n * all.length);
  for (const [column, values] of all.entries()) {
    for (let i = 0; i < ticket.n; i++) result[i * all.length + column] = values[i];
  }
  return result;
}
