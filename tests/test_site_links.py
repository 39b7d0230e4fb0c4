"""Old addresses of the built site lead on; its check finds what leads nowhere, and nothing else."""

import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[1] / "docs"
site_links = runpy.run_path(str(DOCS / "site_links.py"))
answer_moved, broken = site_links["answer_moved"], site_links["broken"]
GOOD = (
    '<h2 id="teeth">Teeth</h2><a name="old"></a><a href="#teeth">here</a><a href="">top</a>'
    '<a href="sub/b%20c.html?d=1#caf%C3%A9">there</a><img src="_images/p.png" alt="">'
    '<a href="https://example.org/none">elsewhere</a><img src="data:image/png;base64,AA==">'
    '<script>"<img src=none.png>"</script>'
)


@pytest.fixture
def site(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "_images").mkdir()
    (tmp_path / "_static").mkdir()
    (tmp_path / "_images" / "p.png").write_bytes(b"")
    (tmp_path / "_static" / "macros.html").write_text('<link href="{{ theme }}">', "utf-8")
    back = '<p id="café"><a href="../a.html#old">back</a></p>'
    (tmp_path / "sub" / "b c.html").write_text(back, "utf-8")
    (tmp_path / "a.html").write_text(GOOD, "utf-8")
    return tmp_path


def test_a_whole_site_has_none(site):
    assert list(broken(site)) == []


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ('<img src="images/p.png">', "a.html: images/p.png leads to no file"),
        ('<a href="sub">', "a.html: sub leads to no file"),
        ('<a href="sub/b%20c.html#teeth">', "b%20c.html#teeth leads to no place on that page"),
        ('<a href="#tooth">', "a.html: #tooth leads to no place on that page"),
    ],
)
def test_each_fault_is_told_once(site, fault, told):
    (site / "a.html").write_text(GOOD + 2 * fault, "utf-8")
    (line,) = broken(site)
    assert line.endswith(told)


def test_an_old_address_leads_to_the_new_page(site):
    answer_moved(site, {"old": "a#teeth", "older": "a", "wrong": "a#tooth"})
    assert 'content="0; url=a.html#teeth"' in (site / "old.html").read_text("utf-8")
    assert 'content="0; url=a.html"' in (site / "older.html").read_text("utf-8")
    assert list(broken(site)) == ["wrong.html: a.html#tooth leads to no place on that page"]
