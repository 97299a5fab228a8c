"""The command line: what it prints, and how it answers mistakes."""

import subprocess
import sys

import imageio.v3 as iio
import pytest

import handlab
from handlab import cli

FAST = ["--size", "160x120", "--fps", "5", "--seconds", "0.4", "--no-muscles"]


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HANDLAB_DEBUG", raising=False)


def test_the_command_is_installed_and_says_its_version():
    done = subprocess.run([sys.executable, "-m", "handlab.cli", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == handlab.__version__


def test_help_names_every_command(capsys):
    assert cli.answer(["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(command in shown for command in ("run", "pictures", "render", "curves", "plot", "clips", "info", "doctor"))


def test_a_clip_becomes_a_film(tmp_path, capsys):
    assert cli.answer(["render", "fist", "-o", "fist.mp4", "--skin", "translucent", "--view", "palm", *FAST]) == 0
    assert iio.imread(tmp_path / "fist.mp4").shape == (3, 120, 160, 3)
    assert capsys.readouterr().out.strip() == "fist.mp4"


def test_the_relaxed_hand_becomes_a_picture(tmp_path):
    assert cli.answer(["render", "rest", "--size", "160x120", "--side", "left"]) == 0
    assert iio.imread(tmp_path / "rest.png").shape == (120, 160, 3)


def test_key_frames_of_ones_own_become_a_table(tmp_path):
    (tmp_path / "mine.csv").write_text("time,FDP2\n0,0\n0.4,0.5\n")
    assert cli.answer(["render", "mine.csv", "-o", "mine_table.csv", "--hold", "wrist"]) == 0
    assert (tmp_path / "mine_table.csv").read_text().startswith("time_s,")


def test_curves_are_plotted(tmp_path):
    assert cli.answer(["curves", "fist", "--muscles", "FDP2", "EDC2", "--joints", "mcp2", "pip2", "--seconds", "0.3"]) == 0
    assert (tmp_path / "fist_curves.png").stat().st_size > 10_000


@pytest.mark.parametrize("what", ["lever-arms", "force-length"])
def test_all_muscles_are_plotted(tmp_path, what):
    assert cli.answer(["plot", what]) == 0
    assert (tmp_path / f"{what}.png").stat().st_size > 10_000


def test_clips_are_listed(capsys):
    assert cli.answer(["clips"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in handlab.clips())
    assert "fist" in shown


def test_info_prints_meshes_quality_muscles_joints_and_assumptions(capsys):
    assert cli.answer(["info"]) == 0
    shown = capsys.readouterr().out
    for word in ("29 bones", "triangles", "quality", "FDP2", "mcp2.flexion_extension", "newton_per_percent", "assumption"):
        assert word in shown
    assert "  NO" not in shown


def test_info_prints_one_muscle_with_its_sources(capsys):
    assert cli.answer(["info", "FDP2"]) == 0
    assert "flexor_digitorum_profundus_index" in capsys.readouterr().out


def test_doctor_finds_this_machine_well(capsys):
    assert cli.answer(["doctor"]) == 0
    shown = capsys.readouterr().out
    assert "ffmpeg" in shown
    assert all(line.startswith("ok") for line in shown.splitlines())


def test_doctor_says_what_to_install_and_fails(capsys, monkeypatch):
    from handlab.show import facts
    from handlab.show.doctor import Finding

    monkeypatch.setattr(facts, "check_drawing", lambda: Finding(False, "no picture", "install libegl1"))
    assert cli.answer(["doctor"]) == cli.TROUBLE
    assert "install libegl1" in capsys.readouterr().out


@pytest.mark.parametrize("line", ["", "run", "run --side left --reading printed --port 8800 --host localhost --no-browser", "--port 0"])
def test_run_and_no_command_open_the_live_hand(monkeypatch, line):
    from handlab.show.app import server

    asked = {}
    monkeypatch.setattr(server, "start", lambda load, **how: asked.update(how, hand=load().hand))
    assert cli.answer(line.split()) == 0
    assert asked["host"] == ("localhost" if "localhost" in line else "127.0.0.1")
    assert asked["port"] == (8800 if "8800" in line else 0 if "0" in line else 8765)
    assert asked["browser"] is ("--no-browser" not in line)
    assert (asked["hand"].side, asked["hand"].reading) == (("left", "printed") if "left" in line else ("right", "sound"))


def test_pictures_draws_the_fist_and_names_the_files(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(cli, "PICTURES_SIZE", (320, 160))
    monkeypatch.setattr(cli, "PICTURES_FPS", 5)
    assert cli.answer(["pictures", "--no-show"]) == 0
    shown = capsys.readouterr().out
    for name in ("fist.mp4", "fist.png"):
        assert (tmp_path / "handlab-pictures" / name).stat().st_size > 1000
        assert name in shown


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("render", "WHAT"),
        ("bogus", "bogus"),
        ("rendr fist", "did you mean render"),
        ("run fist", "fist"),
        ("run --port 99999", "65535"),
        ("run --host 198.51.100.7", "no address of this computer"),
        ("run --host no-such-host.invalid", "there is no host"),
        ("render fist --fps x", "--fps"),
        ("render fist -o x.avi", ".mp4, .gif, .png, .csv"),
        ("render fist -o nowhere/x.mp4", "nowhere"),
        ("render fist --size 3", "800x600"),
        ("render fist --size 10x10", "64"),
        ("render fisst", "fist"),
        ("render fist --view plam", "palm"),
        ("render fist --skin glass", "translucent"),
        ("render fist --side up", "side"),
        ("render fist --fps 0", "frames per second"),
        ("render fist --seconds -1", "seconds"),
        ("render fist --hold wrst", "wrist"),
        ("render nothing.csv", "nothing.csv"),
        ("curves fist --muscles FDP22", "flexor_digitorum_profundus"),
        ("info FPD2", "flexor_digitorum_profundus_index"),
        ("plot lever", "lever-arms"),
        ("render broken.csv", "3"),
        ("render rest -o rest.csv", "clip"),
    ],
)
def test_a_mistake_is_answered_with_one_sentence_and_code_2(tmp_path, capsys, line, word):
    (tmp_path / "broken.csv").write_text("time,FDP2\n0,0\n0.4,half\n")
    before = {path.name for path in tmp_path.iterdir()}
    assert cli.answer(line.split()) == cli.USAGE_ERROR
    shown = capsys.readouterr()
    assert shown.out == ""
    said = shown.err.strip().splitlines()[-1]
    assert said.startswith("handlab: ")
    assert word in said
    assert "Traceback" not in shown.err
    assert {path.name for path in tmp_path.iterdir()} == before


def test_a_mistake_shows_where_it_happened_when_asked(monkeypatch):
    monkeypatch.setenv("HANDLAB_DEBUG", "1")
    with pytest.raises(ValueError, match="800x600"):
        cli.answer(["render", "fist", "--size", "3"])


def test_an_unexpected_error_is_one_sentence_too(capsys, monkeypatch):
    monkeypatch.setattr(cli, "load", lambda *_: 1 / 0)
    assert cli.answer(["info"]) == cli.USAGE_ERROR
    assert "HANDLAB_DEBUG=1" in capsys.readouterr().err


def test_a_reader_that_has_seen_enough_ends_the_output_quietly():
    done = subprocess.run(f"{sys.executable} -m handlab.cli info | head -n 1", shell=True, capture_output=True, text=True, check=False)
    assert "Hand 'reference'" in done.stdout
    assert done.stderr == ""


def test_ctrl_c_ends_with_code_130(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "load", interrupted)
    assert cli.answer(["info"]) == cli.INTERRUPTED
