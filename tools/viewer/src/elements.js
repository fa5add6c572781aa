// Short ways to make HTML elements.

export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  Object.assign(element, properties);
  element.append(...children);
  return element;
}

export function button(text, title, onclick) {
  return make("button", { textContent: text, title, onclick, type: "button" });
}

// A switch with the letter that also turns it.
export function toggle(text, key, checked, onchange) {
  const input = make("input", { type: "checkbox", checked });
  input.addEventListener("change", () => onchange(input.checked));
  const label = make(
    "label",
    { className: "toggle", title: `key ${key}` },
    input,
    text,
    make("kbd", { textContent: key }),
  );
  return { label, input };
}

export function slider(min, max, step, value, title, oninput) {
  const input = make("input", { type: "range", min, max, step, title });
  input.value = value;
  input.addEventListener("input", () => oninput(Number(input.value)));
  return input;
}
