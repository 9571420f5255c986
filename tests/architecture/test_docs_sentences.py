"""Sentences of the documentation are short: 40 words in prose, 60 in a cell of a table."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# docs/reproduction.md is written by `make reproduce`.
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(page for page in (ROOT / "docs").rglob("*.md") if page.name != "reproduction.md"),
]
WORDS_OF_PROSE, WORDS_OF_CELL = 40, 60
FENCED = re.compile(r"^( *)(```|\$\$).*?^ *\2$|^    \S[^\n]*$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
BLOCK_START = re.compile(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.)\s|#|\|)|(?<=\n)(#+ .*)\n")
SENTENCE_END = re.compile(r"(?<=[.?!;])[)*\"]*\s+(?=[(*\"]*(?:[A-Z0-9Ω°]|slewtrack))|;\s")
WORD = re.compile(r"\w")


def sentences(text: str):
    """Each sentence or cell's sentence with the words that it may have."""
    text = LINK.sub(r"\1", FENCED.sub("", text))  # a link is its words
    text = re.sub(r"`[^`\n]*`", "Code", text)  # and code is one word
    for block in filter(None, BLOCK_START.split(f"\n{text}")):
        is_row = block.startswith("|")
        most = WORDS_OF_CELL if is_row else WORDS_OF_PROSE
        for cell in block.strip("|").split("|") if is_row else [block]:
            yield from ((part, most) for part in SENTENCE_END.split(cell))


def words(sentence: str) -> int:
    return sum(1 for word in sentence.split() if WORD.search(word))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_sentences_are_short(page):
    long = {
        sentence: f"{words(sentence)} words, {most} at most"
        for sentence, most in sentences(page.read_text(encoding="utf-8"))
        if words(sentence) > most
    }
    assert long == {}


def test_the_count_of_words_sees_prose_lists_and_tables():
    text = "One two `a b c` [four five](x.md). Six\nseven: eight!\n\n- nine ten\n\n| a b | c |\n"
    text += "## Four more\nOne.\n\n    code\n\n```\ncode\n```\nTwo words\n"
    counted = [(words(sentence), most) for sentence, most in sentences(text) if words(sentence)]
    prose = [(5, 40), (3, 40), (2, 40)]
    assert counted == [*prose, (2, 60), (1, 60), (2, 40), (1, 40), (2, 40)]
