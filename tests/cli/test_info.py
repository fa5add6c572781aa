"""`sigmafmu info` fits 80 columns and cuts nothing."""

import io

import pytest
from rich.console import Console

from sigmafmu.info import WIDTH, every_variable, summary


def rendered(renderable, width: int) -> list[str]:
    console = Console(file=io.StringIO(), width=width, force_terminal=False, highlight=False)
    console.print(renderable)
    return console.file.getvalue().splitlines()


@pytest.mark.parametrize("view", [summary, every_variable])
@pytest.mark.parametrize("descriptions", [False, True])
@pytest.mark.parametrize("width", [80, 200])
def test_every_line_fits_and_every_word_is_whole(fmu, model, view, descriptions, width):
    lines = rendered(view(fmu(model), descriptions), width)
    assert [line for line in lines if len(line) > WIDTH and str(fmu(model).path) not in line] == []
    words = " ".join(lines).split()
    wanted = [v.name.partition("[")[0] if view is summary else v.name for v in fmu(model).description.modelVariables]
    present = {word.partition("[")[0] for word in words} if view is summary else set(words)
    assert set(wanted) <= present
    if descriptions:
        text = " ".join(words)
        for v in fmu(model).description.modelVariables:
            assert v.description in text or view is summary
            for item in v.declaredType.items if v.type == "Enumeration" else ():
                assert item.name in text


def test_descriptions_come_on_demand(fmu):
    v = fmu("HeavyTop").variables["top.inertia.xx"]
    short, long = (" ".join(rendered(summary(fmu("HeavyTop"), d), 80)) for d in (False, True))
    assert v.description not in short
    assert "-v tells" in short
    assert v.description in long
