"""Tables of numbers in CSV files."""

import csv
from pathlib import Path


class CsvError(ValueError):
    """One sentence that says what is wrong with a file."""


def read_points(path: Path) -> list[tuple[int, float, float]]:
    """Line and first two columns of a CSV file; a first line of words is a header.

    Raises CsvError where the file cannot be read or has a line without two numbers.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise CsvError(f"cannot be read: {error.strerror}; it must be a CSV file") from error
    except UnicodeDecodeError as error:
        raise CsvError("cannot be read: it is no text; it must be a CSV file") from error
    points = []
    for number, row in enumerate(csv.reader(lines), 1):
        if not any(cell.strip() for cell in row):
            continue
        try:
            x, y = (float(cell) for cell in row[:2])
        except ValueError as error:
            if not points and number == 1:
                continue
            raise CsvError(f"has no two numbers in line {number}; every line must begin with time and value") from error
        points.append((number, x, y))
    return points
