"""Styles that matplotlib takes and cannot draw: the style's fault, by its line, before any work."""

import io

import pytest

import camcli
from camcli.errors import Fault, SceneError
from tests.conftest import refused
from tests.support.bounds import limited

SIMULATE = "simulate --set run.transient=1 --set run.record=2 --style it.mplstyle"
WRONG = {  # a line of a style, and what is said of it
    "lines.linewidth: inf": "found lines.linewidth: inf, expected finite numbers",
    "font.size: nan": "found font.size: nan, expected finite numbers",
    "font.size: 1e6": "expected finite numbers of at most 1000",
    "xtick.major.size: inf": "expected finite numbers",
    "path.sketch: (inf, inf, inf)": "expected finite numbers",
    "legend.numpoints: 1000000000": "expected finite numbers of at most 1000",  # it hung
    "savefig.dpi: 1e6": "found savefig.dpi: 1e6, expected 20 to 1200",  # it took all memory
    "savefig.dpi: 0": "expected 20 to 1200",
    "figure.dpi: -3": "expected 20 to 1200",
    "axes.prop_cycle: cycler('color', [])": "found axes.prop_cycle, in which nothing can be drawn",
    "axes.prop_cycle: cycler('color', 'r'*10**9)": "found no setting of matplotlib",
    "axes.prop_cycle: cycler('color', 'rgb'*9*9*9*9)": "found no setting of matplotlib",
    "axes.prop_cycle: cycler('color', [9**9**9])": "found no setting of matplotlib",
    "lines.marker: zz": "in which nothing can be drawn (Unrecognized marker style 'zz')",
    "axes.prop_cycle: cycler('marker', ['zz'])": "found axes.prop_cycle, in which nothing can be",
    "scatter.marker: zz": "found scatter.marker, in which nothing can be drawn",
    "legend.numpoints: 0": "found legend.numpoints, in which nothing can be drawn",
    "image.cmap: nosuch": "found image.cmap, in which nothing can be drawn",
    "font.style: zz": "found font.style, in which nothing can be drawn",
    "image.interpolation: nosuch": "found image.interpolation, in which nothing can be drawn",
    "font.family: nosuchfont": "found font.family: nosuchfont, expected an installed font",
    "text.nosuch: 1": "found no setting of matplotlib",
}
BETWEEN = "axes.titlesize: 9\n# a comment\n\n"


@pytest.mark.parametrize("line", WRONG)
def test_a_style_that_cannot_be_drawn_is_refused_with_its_line(cam, tmp_path, line):
    style = tmp_path / "it.mplstyle"
    style.write_text(f"{BETWEEN}{line}\naxes.labelsize: 8\n")
    with limited(20.0):
        done = cam(SIMULATE)
    refused(done, "it.mplstyle:4: plot.style: ", WRONG[line])
    assert list(tmp_path.iterdir()) == [style]


def test_tex_without_latex_is_the_fault_of_the_style(cam, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))  # where there is no latex
    (tmp_path / "it.mplstyle").write_text(f"{BETWEEN}text.usetex: True\n")
    refused(cam(SIMULATE), "it.mplstyle:4: plot.style: found text.usetex, in which nothing can be")


@pytest.mark.parametrize(
    "line",
    ["agg.path.chunksize: 20000", "lines.linewidth: 2", "font.family: serif",
     "font.family: nosuchfont, DejaVu Sans",
     "axes.prop_cycle: cycler('color', ['r', 'ff00ff']) * cycler('linestyle', ['-', '--'])"],
)  # fmt: skip
def test_styles_that_can_be_drawn_are_taken(cam, tmp_path, line):
    (tmp_path / "it.mplstyle").write_text(f"{BETWEEN}{line}\n")
    cam(SIMULATE, code=0)


def test_a_picture_that_only_its_style_forbids_costs_no_table(cam, tmp_path, monkeypatch):
    """The small picture may be drawn where a large one fails: what was computed is kept."""
    monkeypatch.setattr("camcli.plots.style.check_look", lambda font, sheet: None)
    (tmp_path / "it.mplstyle").write_text("lines.marker: zz\n")
    done = cam(SIMULATE)
    refused(done, "it.mplstyle: plot.style: found a style in which simulate.png cannot be drawn")
    assert (tmp_path / "out/simulate/trajectory.csv").exists()
    assert not (tmp_path / "out/simulate/simulate.png").exists()


@pytest.mark.parametrize("style", [None, "ggplot"])
@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), SceneError(Fault("out", "", "full", "", ""))]
)
def test_a_picture_that_cannot_be_written_is_no_fault_of_its_style(monkeypatch, style, error):
    """And none that is half written is called done."""

    def write(*_):
        raise error

    monkeypatch.setattr("camcli.output.pictures.write_picture", write)
    scene = camcli.load_scene(None, {"plot.style": style, "simulate.profile_only": True})
    result = camcli.simulate(scene)
    with pytest.raises(type(error)) as raised:
        result._draw("profile", "png", io.BytesIO())
    assert raised.value is error
