"""The paper's figures, made again: each of the nine is there, with words and a verdict."""

import re

import pytest

from kinetics import cli

SMALL = ("--media", "2", "--tracers", "10", "--free-tracers", "2000", "--count", "200")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    arguments = ["report", "--figures-of-the-paper", "-o", str(folder), "--figures", "png", *SMALL]
    assert cli.main(arguments) == 0
    return folder


def test_the_page_has_all_nine_figures_with_what_the_paper_shows_and_a_verdict(folder):
    page = (folder / "figures-of-the-paper.html").read_text()
    assert re.findall(r'<figure id="figure-(\d)"', page) == list("123456789")
    assert page.count("In the paper:") == 9
    assert page.count("Here:") == 9


def test_each_figure_is_written_as_a_file(folder):
    files = sorted(path.name for path in folder.glob("*.png"))
    assert files == [f"figures-of-the-paper-{number}.png" for number in range(1, 10)]


@pytest.mark.parametrize("option", [("-e", "0.5"), ("--system", "bath"), ("--json",)])
def test_options_of_other_reports_are_refused(option, tmp_path):
    arguments = ["report", "--figures-of-the-paper", "-o", str(tmp_path / "new"), *option]
    assert cli.main(arguments) != 0
    assert not (tmp_path / "new").exists()
