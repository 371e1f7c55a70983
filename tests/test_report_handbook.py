"""The handbook in the report: every link resolves, no HTML of a text is passed on, and a page follows its Markdown."""

import re
import shutil
from collections import Counter
from html import unescape
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote

import handbook
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_pages import Page, stamps
from sample_study import store, study

from mpmverify.dataset.files import Results
from mpmverify.reports import manifest, render
from mpmverify.reports.handbook_page import handbook_pages
from mpmverify.reports.highlight import highlighted
from mpmverify.reports.prose import anchor, prose
from mpmverify.reports.site import render as html

TEXTS = {path.name: path.read_text(encoding="utf-8") for path in handbook.FOLDER.iterdir()}
PAGES = {name.removeprefix("handbook/"): page for name, page in handbook_pages(TEXTS, "mpmverify test").items()}
HOSTILE = (
    "<script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "a <b onclick='x'>b</b> c",
    "[x](javascript:alert(1))",
    "![x](javascript:alert(1))",
    "[x](data:text/html,<script>1</script>)",
    "<!-- a --> <iframe src='x'></iframe>",
    "<!-- never closed <script>alert(1)</script>",
    "```<script>\n</code></pre><script>alert(1)</script>\n```",
    "| <i>a</i> | b |\n| --- | --- |\n| <script>1</script> | `<u>` |",
    "## <script>alert(1)</script>",
    "## \"quoted\" & 'single'",
    "<div>\n\n## in a block\n\n</div>",
    "> ## in a quotation\n\n- ## in a list",
    '[x](other.md "<script>")',
)


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Page]:
    """Pages of the handbook by their name, parsed."""
    folder = tmp_path_factory.mktemp("handbook")
    for name, page in PAGES.items():
        (folder / f"{name}.html").write_text(html(page), encoding="utf-8")
    return {path.name: Page(path) for path in folder.glob("*.html")}


@pytest.fixture
def report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Results:
    """A report whose handbook is a copy."""
    shutil.copytree(handbook.FOLDER, tmp_path / "copy")
    for module in ("manifest", "site"):
        monkeypatch.setattr(f"mpmverify.reports.{module}.HANDBOOK", tmp_path / "copy")
    results = Results(tmp_path / "results")
    store(results, study(solvers=("good",)))
    render(results)
    return results


def body(text: str) -> str:
    """A text as HTML, on a page whose neighbours are `other.md` and `picture.svg`."""
    pages = handbook_pages(
        {"README.md": "# Index\n\n[Text](text.md)", "text.md": text, "other.md": "", "picture.svg": ""}, "test"
    )
    return pages["handbook/text"].body


def test_every_text_has_a_page_and_the_index_says_their_order():
    listed = re.findall(r"\]\((\w[\w-]*)\.md\)", TEXTS["README.md"])
    assert list(PAGES) == ["index", *listed]
    assert [PAGES[name].title for name in ("index", "verdicts")] == ["Handbook", "Verdicts"]


def test_every_link_and_anchor_resolves_and_none_leads_to_markdown(rendered):
    for name, page in rendered.items():
        assert [identifier for identifier, count in Counter(page.ids).items() if count > 1] == []
        for link in page.links:
            assert not link.partition("#")[0].endswith(".md"), f"{name} links to {link}"
            if link.startswith(("https://", "../", "#icon", "#marker")):
                continue
            target, _, part = link.partition("#")
            assert (target or name) in rendered, f"{name} links to {link}"
            assert not part or unquote(part) in rendered[target or name].ids, f"{name} links to {link}"


def test_pictures_are_files_of_the_handbook(rendered):
    shown = {source for page in rendered.values() for source in page.resources if source.endswith(".svg")}
    assert shown
    assert shown <= TEXTS.keys()


def test_all_that_a_text_says_is_on_its_page(rendered):
    for path in handbook.FOLDER.glob("*.md"):
        name = "index.html" if path.name == "README.md" else f"{path.stem}.html"
        text = "".join(rendered[name].text)
        for block in handbook.blocks(path):
            assert block.text in text
        said = re.sub(r"!\[[^\]]*\]\([^)]*\)|\]\([^)]*\)|<!--.*?-->|```\w*", "", handbook.text(path))
        lacking = [word for word in set(re.findall(r"[A-Za-z]{4,}", said)) if word not in text]
        assert not lacking, name


def test_headings_are_the_contents_and_have_the_anchors_of_forges():
    for page in PAGES.values():
        links = [link for section in page.sections for link in (section.link, *section.parts)]
        assert page.body.count("<h2") + page.body.count("<h3") == len(links)
        assert all(f'id="{link.href[1:]}"' in page.body for link in links)
    assert anchor("The rooms of mpmverify/: a, b") == "the-rooms-of-mpmverify-a-b"


def test_equal_headings_have_different_anchors():
    found = prose("## A\n\n## A\n\n## Content\n\n## ?\n\n## A-1", lambda _: None).headings
    assert len({heading.anchor for heading in found} | {"content", "provenance", ""}) == len(found) + 3


def test_pages_lead_to_the_ones_before_and_after():
    pages = list(PAGES.values())
    assert pages[0].previous is pages[-1].following is None
    for before, after in pairwise(pages):
        assert before.following.text == after.title
        assert after.previous.text == before.title
        assert [link.text for link in after.chapters if link.current] == [after.title]


def test_a_link_out_of_the_handbook_is_left_as_text():
    assert body("see [the `README`](../../README.md#x) here") == "<p>see <span>the <code>README</code></span> here</p>\n"
    assert body("[a](https://a.b) [b](other.md#c)").count("<a href=") == 2
    assert 'href="other.html#c"' in body("[b](other.md#c)")
    assert 'href="index.html"' in body("[b](README.md)")


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_text_is_shown_as_text(text, tmp_path):
    page = tmp_path / "text.html"
    content = handbook_pages({"README.md": "# Index", "text.md": text, "other.md": ""}, "test")["handbook/text"]
    page.write_text(html(content), encoding="utf-8")
    parsed = Page(page)
    assert parsed.scripts == 1, "the script of the report"
    assert not re.search(r"<(script|img|iframe|b|i|u|div)\b(?! class| src=\"\.\./assets)", content.body)
    assert not re.search(r"(href|src)=\"(javascript|data)", content.body)
    for word in re.findall(r"alert\(1\)", text):
        assert word in "".join(parsed.text)


@given(st.sampled_from(["sh", "python", "yaml", "csv", ""]), st.text(alphabet="ab =\"'#<>&@:$1\n\t\\-", max_size=60))
def test_code_with_marks_is_the_same_text(language, code):
    marked = highlighted(code, language)
    assert unescape(re.sub(r'<span class="\w+">|</span>', "", marked)) == code
    assert highlighted("x = 1  # one", "python") == 'x = <span class="number">1</span>  <span class="comment"># one</span>'


def test_comments_are_not_shown_and_name_the_file_of_a_block():
    assert body("<!-- a -->\n\ntext <!-- b --> more") == "<p>text  more</p>\n"
    shown = body("<!-- parsed: why -->\n<!-- file: a<b.py -->\n```python\nx = 1 < 2\n```")
    assert "parsed" not in shown
    assert '<p class="file">a&lt;b.py</p>' in shown
    assert '<code>x = <span class="number">1</span> &lt; <span class="number">2</span>\n</code>' in shown


@given(st.text(alphabet="#>-*`|<!&[]()\n\\ ab\"'=/", max_size=80))
def test_any_text_gives_balanced_html_without_tags_of_its_own(tmp_path_factory, text):
    path = tmp_path_factory.getbasetemp() / "any.html"
    path.write_text(body(text), encoding="utf-8")
    page = Page(path)
    assert not page.scripts
    assert all(link == "" or link.startswith(("#", "other.html", "index.html")) for link in page.links)


def test_code_tables_and_pictures_scroll_and_take_the_focus():
    shown = body("| a | b |\n| --- | --- |\n| 1 | 2 |\n\n```sh\nx\n```\n\n![what](picture.svg)\n")
    labels = re.findall(r'<div class="scroll[^"]*" tabindex="0" role="region" aria-label="([^"]+)">', shown)
    assert labels == ["Table 1", "Shell, block 1", "Picture 1"]
    assert shown.count("scroll") == 3


def test_the_heads_of_a_table_label_the_cells_that_become_blocks():
    narrow = body("| a | `b` | c |\n| --- | --- | --- |\n| 1 | 2 | 3 |")
    assert re.findall('data-head="(.)"', narrow) == ["b", "c"]
    wide = body("| | b | c | d |\n| --- | --- | --- | --- |\n| 1 | 2 | 3 | 4 |")
    assert "data-head" not in wide
    assert wide.count("<th ") == 3, "an empty head is a plain cell"


def test_a_changed_text_is_rendered_anew_and_the_page_of_a_removed_one_is_deleted(report):
    folder, place = manifest.HANDBOOK, report.report / "handbook"
    before = stamps(report)
    render(report)
    assert stamps(report) == before
    (folder / "speed.md").write_text("# Speed\n\nNew.\n", encoding="utf-8")
    render(report)
    after = stamps(report)
    changed = {Path(name).name for name in after if after[name] != before[name]}
    whole = {name for name in changed if name.startswith(("solver", "compare", "problems"))}
    assert changed - whole == {"speed.html", "index.html", "manifest.json"}, "besides the pages of all studies, always written"
    assert after[str(place / "index.html")] == before[str(place / "index.html")]
    (folder / "speed.md").unlink()
    (folder / "own-solver.svg").unlink()
    render(report)
    assert not (place / "speed.html").exists()
    assert not (place / "own-solver.svg").exists()
    assert (place / "architecture.svg").exists()


def test_a_page_or_picture_that_was_changed_or_lost_is_written_again(report):
    place = report.report / "handbook"
    sound = {path.name: path.read_bytes() for path in place.iterdir()}
    (place / "trust.html").unlink()
    (place / "ci.html").write_bytes(sound["ci.html"][:-50])
    (place / "own-solver.svg").write_text("<svg/>")
    render(report)
    assert {path.name: path.read_bytes() for path in place.iterdir() if path.suffix != ".damaged"} == sound


def test_the_report_links_terms_to_the_handbook(report):
    links = set(Page(report.report / "index.html").links)
    assert {"handbook/index.html", "handbook/verdicts.html", "handbook/verdicts.html#two-gates"} <= links
    assert "handbook/index.html" in Page(report.report / "sample.html").links
    assert "../index.html" in Page(report.report / "handbook" / "index.html").links
