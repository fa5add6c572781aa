"""The folder `documentation` of an FMU: index.html, fmi-ls-ref.html, the figure, and the licences."""

import re
import shutil
from itertools import groupby
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from . import markdown
from .description import Description, Group, Variable
from .draw import Picture
from .model_description import LICENSE
from .numbers_in_text import keep_together
from .reference import FOLDER, SAFETY, Experiment

HERE = Path(__file__).parent
SOURCE = "source"
"""Folder of the file that a mechanism was made from."""


def write(
    description: Description,
    picture: Picture,
    texts: Path,
    out: Path,
    *,
    experiment: Experiment | None = None,
    source: Path | None = None,
    ours: bool,
) -> None:
    """Writes the documentation of a model into the FMU's folder `out`.

    `texts` is the folder of LICENSE and docs/, from which it quotes: what they say of the mechanism if it is `ours`.
    The file `source`, from which the mechanism was made, is put beside.
    """
    folder = out / "documentation"
    shutil.copytree(HERE / "licenses", folder / "licenses")
    shutil.copyfile(texts / "LICENSE", folder / "licenses" / "sigmafmu-BSD-3-Clause.txt")
    if source:
        (folder / SOURCE).mkdir()
        shutil.copyfile(source, folder / SOURCE / source.name)
    figure = f"{description.model}.png"
    picture.save(folder / figure)

    mechanisms, fmi, method = (_read(texts / "docs" / name) for name in ("mechanisms.md", "fmi.md", "method.md"))
    preamble = markdown.preamble(mechanisms)
    environment = Environment(
        loader=FileSystemLoader(HERE / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    facts = {
        "fmu": description,
        "experiment": experiment,
        "figure": figure,
        "license": LICENSE,
        "source": {"name": source.name, "url": f"{SOURCE}/{quote(source.name)}"} if source else None,
        "ls_ref": FOLDER.as_posix(),
        "safety": SAFETY,
        "flexible": description.owners("body", "flexible"),
        "joints": description.owners("joint"),
    }
    index = environment.get_template("index.html.j2").render(
        facts,
        frames=_html(preamble if ours else preamble.strip().partition("\n\n")[0]),  # what follows is about ours
        mechanism=_html((markdown.section(mechanisms, description.model) if ours else None) or ""),
        master=_html(fmi.partition("\n")[2]),
        limits=Markup(" ").join(_limits(description)),
        failing=_html(_section(method, "When a step fails")),
        formulations=_html(_section(method, "What to expect of the formulations")),
        tables=[(_title(g), _anchor(g.owner), _rows(description, g.variables)) for g in description.groups],
    )
    (folder / "index.html").write_text(keep_together(index), encoding="utf-8")
    if experiment:
        page = environment.get_template("fmi-ls-ref.html.j2").render(facts)
        (folder / "fmi-ls-ref.html").write_text(keep_together(page), encoding="utf-8")


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _html(text: str) -> Markup:
    return Markup(markdown.html(text))


def _limits(description: Description) -> list[Markup]:
    """Sentences about what a model of this mechanism leaves out, and when its internal step changes."""
    flexible, joints = description.owners("body", "flexible"), description.owners("joint")
    springs = description.owners(
        "force", "spring-damper", "line spring", "table spring", "torsion spring", "bushing", "bearing"
    )
    contacts = description.owners("force", "plane contact", "sphere contact", "cloud contact")
    if flexible:
        names = Markup(" and ").join(Markup("<code>{}</code>").format(name) for name in flexible)
        others = "every other body is rigid" if description.owners("body", "rigid") else "there is no rigid body"
        bends = "bends" if len(flexible) == 1 else "bend"
        how = "linear modes, without the stiffening of a body that turns fast or bends far"
        sentences = [names + f" {bends} a little: {how}; {others}."]
    else:
        sentences = ["Bodies are rigid."]
    if joints:
        sentences += [
            "Joints are ideal: no friction, no play, no stops.",
            "The initial state must be near one that can be assembled, else initialization fails.",
        ]
    else:
        sentences.append("There are no joints.")
    parts = [name for name, owners in (("joints", joints), ("springs", springs), ("contacts", contacts)) if owners]
    if parts:
        sentences.append(f"The geometry of {' and '.join(parts)} is fixed.")
    if contacts:
        sentences.append("Contacts are no events: steps must be short enough for an impact, or adapt to the error.")
    else:
        sentences.append("There is no contact and no event.")
    adapting = [Markup("<code>integrator.method = rkmk54</code>")]
    if any(v.name == "integrator.stepControl" for v in description.variables):
        adapting.append(Markup("<code>integrator.stepControl = error</code>"))
    sentences += [
        Markup("With ") + Markup(" or ").join(adapting) + " the internal step adapts to the error.",
        Markup("Else it is as long as <code>integrator.stepSize</code> allows, and shorter only where a step fails."),
    ]
    return [Markup(sentence) for sentence in sentences]


def _section(text: str, title: str) -> str:
    found = markdown.section(text, title)
    if found is None:
        raise LookupError(f"docs/method.md has no section '{title}', which the FMU's documentation quotes")
    return found


def _title(group: Group) -> str:
    if not group.kind:
        return group.owner[:1].upper() + group.owner[1:] or "Mechanism"
    what = {"station": "point", "force": group.type}.get(group.kind, f"{group.type} {group.kind}")
    return f"{what[0].upper()}{what[1:]} {group.owner}"


def _anchor(owner: str) -> str:
    return f"variables-{owner or 'mechanism'}"


def _rows(description: Description, variables: list[Variable]) -> list[dict[str, str]]:
    """A row for every vector or scalar."""
    return [_row(description, list(elements)) for _, elements in groupby(variables, lambda v: v.vector)]


def _row(description: Description, elements: list[Variable]) -> dict[str, str]:
    first, last = elements[0], elements[-1]
    name = first.name if len(elements) == 1 else re.sub(r"\[(\d+)\]$", rf"[\1…{len(elements)}]", first.name)
    if len(elements) > 1 and last.name != f"{first.vector}[{len(elements)}]":
        raise ValueError(f"the elements of {first.vector} are not in order")
    items = description.enumerations.get(first.declared_type, [])
    return {
        "name": name,
        "causality": first.causality if first.causality != "parameter" else f"{first.variability} parameter",
        "type": first.declared_type or first.type,
        "unit": "" if first["unit"] == "1" else first["unit"],
        "shown": first["displayUnit"],
        **{name: _same(v[name] for v in elements) for name in ("start", "min", "max")},
        "description": first.description,
        "choices": "; ".join(f"{i['value']} {i['name']}: {i['description']}" for i in items),
    }


def _same(values) -> str:
    """One value if all are the same, else all of them."""
    values = list(values)
    return values[0] if len(set(values)) == 1 else ", ".join(values)
