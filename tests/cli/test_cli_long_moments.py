"""Long runs killed at chosen moments: in a record, at every artefact, at every rename."""

import pytest

from tests.parallel.long_runs import Case, command, files, run

TURNS = ("--set", "run.transient=5", "--set", "run.record=5")
SWEEP = ("sweep", "--rpm", "660:760", "--points", "21", "--no-plot", "--threads", "1", *TURNS)
EARLIER = ("--points", "9", "--set", "sweep.tables=npz")


@pytest.fixture(scope="module")
def case(tmp_path_factory):
    """impacts.csv and strobe.csv where an earlier run left impacts.npz and strobe.npz."""
    return Case(tmp_path_factory.mktemp("moments"), SWEEP, EARLIER)


@pytest.fixture(autouse=True)
def _fresh(case):
    case.reset()


@pytest.mark.parametrize("how", ["SIGKILL", "SIGINT", "SIGTERM"])
@pytest.mark.parametrize(("where", "number"), [("half", 1), ("half", 12), ("put", 7), ("put", 21)])
def test_at_a_piece(case, where, number, how):
    code, _ = case.die(where, number, how)
    assert code in (130, -9)
    assert case.check() == 0
    said = case.finish()
    assert (f"going on: {number - 1} pieces" in said) == (number > 1)
    assert ("torn" in said) == (where == "half" and how == "SIGKILL")


@pytest.mark.parametrize("how", ["SIGKILL", "SIGINT"])
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_at_an_artefact_all_are_old(case, number, how):
    assert case.die("fsync", number, how)[0] in (130, -9)
    assert case.check() == 0
    assert "going on: 21 pieces" in case.finish()


@pytest.mark.parametrize("how", ["SIGKILL", "SIGTERM"])
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_at_a_rename_each_is_old_or_new(case, number, how):
    assert case.die("replace", number, how)[0] in (130, -9)
    assert case.check() == number - 1
    assert "going on: 21 pieces" in case.finish()


def test_before_the_pieces_are_forgotten_all_are_new(case):
    for number in range(1, 9):  # leftovers, artefacts of another form, the pieces
        case.reset()
        code, said = case.die("unlink", number, "SIGKILL")
        if code == 0:
            break
        assert code == -9, said
        case.check()
        case.finish()
    assert number > 3


def test_killed_at_every_turn_of_going_on(case):
    for turn in range(6):
        assert case.die("put", 4, ("SIGKILL", "SIGINT", "SIGTERM")[turn % 3])[0] in (130, -9)
        assert case.check() == 0
    assert "going on" in case.finish()


def test_other_work_in_the_folder_is_told_and_kept(case):
    case.die("put", 5, "SIGKILL")
    code, said = run(command(*SWEEP, "--points", "15", "-o", "out"), case.cwd)
    assert code == 0
    assert "keeps unfinished work of other scenes" in said
    assert len(list(case.folder.glob(".*.pieces"))) == 1
    assert "going on: 4 pieces" in case.finish()


def test_pictures_are_whole_too(tmp_path):
    words = ("sweep", "--rpm", "660:760", "--points", "11", *TURNS)
    case = Case(tmp_path, words, ("--points", "5"))
    for where, number in (("fsync", 4), ("replace", 4)):
        case.die(where, number, "SIGKILL")
        case.check()
    case.finish()
    assert files(case.folder)["sweep.png"][:4] == b"\x89PNG"
