"""Universal binaries of macOS: libraries for several processors in one file, as Apple's `lipo -create` makes them.

The file begins with a table, big-endian, of processor, place and size of each (mach-o/fat.h).
"""

import struct
from collections.abc import Sequence

FAT_MAGIC = 0xCAFEBABE
MACH_O_64 = 0xFEEDFACF
ALIGNMENT = 14
"""Each begins at a multiple of 2^14 bytes, a page of Apple's ARM processors."""


def universal_binary(libraries: Sequence[bytes]) -> bytes:
    """One file of Mach-O libraries for different processors."""
    table = struct.pack(">2I", FAT_MAGIC, len(libraries))
    page = 1 << ALIGNMENT
    content, place = b"", page
    for library in libraries:
        magic, cpu, subtype = struct.unpack_from("<3I", library)
        if magic != MACH_O_64:
            raise ValueError(
                f"a library begins with {magic:#x}; it must be Mach-O of 64 bits, which begins with {MACH_O_64:#x}"
            )
        table += struct.pack(">5I", cpu, subtype, place, len(library), ALIGNMENT)
        padded = library.ljust(-(-len(library) // page) * page, b"\0")
        content, place = content + padded, place + len(padded)
    return table.ljust(page, b"\0") + content
