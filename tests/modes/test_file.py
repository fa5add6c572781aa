"""The file: exact numbers, and one sentence for everything that can be wrong with it."""

import json

import numpy as np
import pytest
import scipy.sparse as sp

from sigmafmu import SigmafmuError
from sigmafmu.modes import ModalData, Section, beam_modes, read, shape_modes, write

ARRAYS = ("X", "Phi", "K", "D", "Theta")


def beam() -> ModalData:
    return beam_modes(1.0, Section.rectangle(0.02, 0.03), E=210e9, nu=0.3, density=7850.0, elements=3).damped(0.1, 1e-5)


def cloud() -> dict:
    """A small file's content."""
    data = shape_modes("sine", 0.3, 0.5, EI=(4.0, 6.0), half_size=(0.02, 0.02), modes=(1, 1), sections=4)
    return {"X": data.X.tolist(), "m": data.mass.tolist(), "Phi": data.Phi.tolist(), "K": data.K.tolist()}


def full_mass(n: int) -> np.ndarray:
    return 0.5 / n * (np.eye(n) + 0.1 * np.ones((n, n)) / 3)


@pytest.mark.parametrize("kind", ["nodal", "dense", "sparse"])
def test_numbers_come_back_bit_for_bit(tmp_path, kind):
    data = beam()
    if kind != "nodal":
        mass = (
            full_mass(len(data.X))
            if kind == "dense"
            else sp.diags_array(
                [np.full(len(data.X), 0.1), np.full(len(data.X) - 1, 1 / 30), np.full(len(data.X) - 1, 1 / 30)],
                offsets=[0, 1, -1],
            ).tocsr()
        )
        data = ModalData(data.X, mass, data.Phi, data.K, data.D, data.Theta, data.names, data.note)
    write(data, tmp_path / "a.json")
    again = read(tmp_path / "a.json")
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(again, name), getattr(data, name))
    dense = [m.toarray() if sp.issparse(m) else m for m in (again.mass, data.mass)]
    np.testing.assert_array_equal(*dense)
    assert sp.issparse(again.mass) == (kind == "sparse")
    assert (again.names, again.note) == (data.names, data.note)
    write(again, tmp_path / "b.json")
    assert (tmp_path / "b.json").read_bytes() == (tmp_path / "a.json").read_bytes()


def test_file_tells_what_it_is(tmp_path):
    write(beam(), tmp_path / "a.json")
    content = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert (content["format"], content["version"], content["units"]) == ("sigmafmu modes", 1, "SI")
    np.testing.assert_array_equal(content["frequencies"], beam().frequencies)


def test_the_least_a_file_needs(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps(cloud()), encoding="utf-8")
    data = read(tmp_path / "a.json")
    assert data.D is None
    assert data.Theta is None
    assert data.names == ()


def put(key, value, *place):
    """Change of a file's content: `value` at content[key][place]."""

    def change(content: dict) -> None:
        if not place:
            content[key] = value
            return
        target = content[key]
        for i in place[:-1]:
            target = target[i]
        target[place[-1]] = value

    return change


def rigid_mode(content: dict) -> None:
    """The first mode moves all nodes in y alike."""
    for rows in content["Phi"]:
        rows[0][0], rows[1][0], rows[2][0] = 0.0, 1.0, 0.0


def same_modes(content: dict) -> None:
    for rows in content["Phi"]:
        for row in rows:
            row[1] = row[0]


def without_mass(content: dict) -> None:
    content["m"] = [0.0] * 16


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c.pop("Phi"), "the key 'Phi' is missing; X, Phi, K and m or M are needed"),
        (lambda c: c.pop("m"), "there must be either m"),
        (put("M", np.eye(16).tolist()), "there must be either m"),
        (put("phi", []), "unknown key 'phi'; allowed are format"),
        (put("format", "other"), "format is 'other'; allowed is 'sigmafmu modes'"),
        (put("version", 2), "version is 2; allowed is 1"),
        (put("units", "mm"), "units is 'mm'; allowed is 'SI'"),
        (put("note", 3), "note is 3; it must be a text"),
        (put("names", [1, 2]), "names must be a list of texts"),
        (put("names", ["a", "a"]), "names are a, a; there must be 2 different ones"),
        (put("X", [0.0], 3), "X has rows of different lengths"),
        (put("X", "long", 3, 0), "X must be a list of rows of numbers"),
        (put("K", [1.0, 2.0]), "K must be a list of rows of numbers"),
        (put("K", [[1.0]]), "K is 1 × 1; it must be (n_f, n_f) with n = 16 nodes and n_f = 2 modes"),
        (put("m", [1.0]), "m is 1; it must be (n) with n = 16 nodes"),
        (put("Theta", [[[0.0]]]), "Theta is 1 × 1 × 1; it must be (n, 3, n_f)"),
        (put("D", [[0.0, 1.0], [0.0, 0.0]]), "D is not symmetric: [0, 1] and [1, 0] are 1 and 0"),
        (put("D", [[1.0, 2.0], [2.0, 1.0]]), "D is not positive semidefinite: its smallest eigenvalue is -1"),
        (put("K", 5.0, 0, 1), "K is not symmetric: [0, 1] and [1, 0] are 5 and 0"),
        (put("K", -1e4, 0, 0), "K is not positive semidefinite: [0, 0] on its diagonal is -10000"),
        (put("Phi", float("nan"), 7, 1, 0), "Phi[7, 1, 0] is nan; it must be a finite number"),
        (put("m", -0.1, 5), "m[5] is -0.1 kg; a node's mass must not be negative"),
        (without_mass, "the total mass, the sum of m, is 0 kg; it must be positive"),
        (rigid_mode, "these motions depend on each other: translation y, mode 1 "),
        (same_modes, "these motions depend on each other: mode 1, mode 2 "),
        (put("frequencies", [1.0]), "there are 1 frequencies; there must be one for each of 2 modes"),
        (put("frequencies", [1.0, 2.0]), "frequencies[0] is 1 Hz; from K and the masses it is "),
    ],
)
def test_mistakes(tmp_path, change, message):
    content = cloud()
    change(content)
    (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(SigmafmuError) as error:
        read(tmp_path / "a.json")
    assert message in str(error.value)
    assert str(error.value).startswith(str(tmp_path / "a.json"))


@pytest.mark.parametrize(
    ("mass", "message"),
    [
        ({"rows": [0], "values": [1.0]}, "M has the keys rows, values; a sparse M has rows, columns, values"),
        ({"rows": [0, 1], "columns": [0], "values": [1.0]}, "M has 2 rows, 1 columns, 1 values"),
        ({"rows": [1], "columns": [0], "values": [1.0]}, "M has an entry at [1, 0]; allowed are whole numbers"),
        ({"rows": [0], "columns": [16], "values": [1.0]}, "0 ≤ row ≤ column < 16"),
        ((np.eye(16) - 0.2 * np.ones((16, 16))).tolist(), "M is not positive semidefinite: its smallest eigenvalue"),
    ],
)
def test_mistakes_in_a_mass_matrix(tmp_path, mass, message):
    content = cloud()
    del content["m"]
    content["M"] = mass
    (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(SigmafmuError) as error:
        read(tmp_path / "a.json")
    assert message in str(error.value)


def test_no_json(tmp_path):
    (tmp_path / "a.json").write_text("{", encoding="utf-8")
    with pytest.raises(SigmafmuError, match="is not a JSON file"):
        read(tmp_path / "a.json")
    (tmp_path / "a.json").write_text("[]", encoding="utf-8")
    with pytest.raises(SigmafmuError, match="the file holds a list"):
        read(tmp_path / "a.json")
    with pytest.raises(SigmafmuError, match=r"cannot read .*: No such file"):
        read(tmp_path / "b.json")
    with pytest.raises(SigmafmuError, match="cannot write"):
        write(beam(), tmp_path / "no" / "a.json")


@pytest.mark.parametrize("scale", ["mass", "displacement", "none"])
def test_scaling_keeps_the_body(scale):
    """Natural frequencies of the reduced body do not depend on the scale of its modes."""
    data = shape_modes("polynomial", 1.0, 1.0, EI=(8.0, 12.0), half_size=(0.02, 0.02)).damped(0.1, 1e-3)
    scaled = data.scaled(scale)
    for A in (data, scaled):
        A_mass = A.modal_mass
        np.testing.assert_allclose(
            np.sort(np.linalg.eigvals(np.linalg.solve(A_mass, A.K)).real),
            np.sort(np.linalg.eigvals(np.linalg.solve(data.modal_mass, data.K)).real),
            rtol=1e-10,
        )
        np.testing.assert_allclose(A.D, 0.1 * A_mass + 1e-3 * A.K, rtol=1e-10, atol=1e-12 * np.abs(A.D).max())
    if scale == "mass":
        np.testing.assert_allclose(scaled.modal_mass, np.eye(4), atol=1e-12)
        np.testing.assert_allclose(scaled.K, np.diag(np.diag(scaled.K)), atol=1e-11 * scaled.K.max())
    if scale == "displacement":
        np.testing.assert_allclose(np.linalg.norm(scaled.Phi, axis=1).max(axis=0), 1.0, rtol=1e-14)
