"""What the site of `make docs` is made of: pages, their order, and the public names."""

import re

import pytest

import sigmafmu.gym
from docs_site import LINK, on_site, write
from research import gallery

from .pages import PAGES, ROOT, read

LINES_OF_A_SCREEN = 45
BYTES_OF_THE_GALLERY = 2_000_000


def names_of_pages():
    return {page.name for page in PAGES if page.name != "README.md"}


def test_every_page_is_in_the_navigation():
    shown = re.findall(r'"([\w-]+\.md)"', read(ROOT / "zensical.toml"))
    assert len(shown) == len(set(shown))
    assert set(shown) == names_of_pages() | {"index.md"}


def test_every_page_is_in_the_list_of_pages():
    listed = set(re.findall(r"\]\(([\w-]+\.md)", read(ROOT / "docs" / "pages.md")))
    assert listed == names_of_pages() - {"pages.md"}


def test_every_public_name_is_in_the_reference():
    told = re.findall(r"^::: sigmafmu\.([\w.]+)$", read(ROOT / "docs" / "api.md"), re.MULTILINE)
    in_gym = {f"gym.{name}" for name in sigmafmu.gym.__all__}
    assert sorted(told) == sorted({*sigmafmu.__all__, *in_gym} - {"__version__"})


def test_every_public_name_has_a_docstring():
    for name in sigmafmu.__all__:
        thing = getattr(sigmafmu, name)
        assert thing.__doc__, name
        for key, member in vars(thing).items() if isinstance(thing, type) else ():
            if not key.startswith("_") and (callable(member) or isinstance(member, property)):
                assert member.__doc__, f"{name}.{key}"


def test_readme_is_a_screen_with_one_picture():
    text = read(ROOT / "README.md")
    assert len(text.splitlines()) <= LINES_OF_A_SCREEN
    assert text.count("![") == 1


def test_gallery_shows_every_mechanism():
    """As its command writes it, with no picture more."""
    assert set(gallery.TAKES) == set(gallery.targets())
    assert read(ROOT / "docs" / "gallery.md") == gallery.text()
    pictures = list((ROOT / "docs" / "images" / "gallery").iterdir())
    assert {path.name for path in pictures} == {f"{name}.webp" for name in gallery.TAKES}
    assert sum(path.stat().st_size for path in pictures) < BYTES_OF_THE_GALLERY


def test_links_of_pages(tmp_path):
    """README.md is the first page; what is not in docs/ comes along."""
    page = ROOT / "docs" / "fmi.md"
    assert on_site(page, "view.md", tmp_path) == "view.md"
    assert on_site(ROOT / "README.md", "docs/view.md", tmp_path) == "view.md"
    assert on_site(page, "../README.md", tmp_path) == "index.md"
    assert on_site(page, "../LICENSE", tmp_path) == "source/LICENSE"
    assert (tmp_path / "source" / "LICENSE").read_text("utf-8") == (ROOT / "LICENSE").read_text("utf-8")
    with pytest.raises(FileNotFoundError, match=r"fmi\.md links to images/nothing\.png, which is not there"):
        on_site(page, "images/nothing.png", tmp_path)


def test_every_link_leads_to_a_file_and_examples_are_shown(tmp_path):
    write(tmp_path / "pages")
    text = read(tmp_path / "pages" / "start.md")
    assert read(ROOT / "docs" / "examples" / "first_fmu.py") in text


def test_other_links_stay():
    text = "[a](#here) [b](https://x.y) [c](mailto:z) [d](fmi.md#there) ![e](images/a.png)"
    assert LINK.sub("*", text) == "[a](#here) [b](https://x.y) [c](mailto:z) [d](*#there) ![e](*)"
