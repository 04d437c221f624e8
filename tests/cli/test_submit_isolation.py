"""What a check of an entry plays: exactly the files that its seed follows from."""

from __future__ import annotations

import sys

import pytest

from cli.entries import DRIVER, change, python_entry
from jaxwalk.cli import main


def test_a_link_is_no_file_of_an_entry(zoo, capsys):
    (zoo / "weights.onnx").touch()
    (zoo / "bold" / "driver.onnx").symlink_to(zoo / "weights.onnx")
    assert main(["submit", "zoo/bold"]) == 2
    assert "zoo/bold/driver.onnx: is a link" in capsys.readouterr().err


def test_entries_may_have_modules_of_the_same_names(of_python, zoo):
    assert main(["submit", "zoo/slow", "zoo/fast", "--check"]) == 0
    assert of_python == [0.1, 0.1, 1.0, 1.0]
    assert not list(zoo.rglob("__pycache__")) and "network" not in sys.modules


def test_a_module_of_elsewhere_is_refused(of_python, zoo, capsys, monkeypatch):
    (zoo / "shared").mkdir()
    (zoo / "fast" / "network.py").rename(zoo / "shared" / "network.py")
    monkeypatch.syspath_prepend(zoo / "shared")
    assert main(["submit", "zoo/fast", "zoo/slow", "--check"]) == 2
    shown = capsys.readouterr()
    assert f"network: the driver imports this module from {zoo / 'shared'}; put it into {zoo / 'fast'}" in shown.err
    assert of_python == [0.1, 0.1]
    assert "| slow | yes |" in shown.out and not (zoo / "fast" / "checked.json").exists()
    assert "network" not in sys.modules


def test_a_package_without_init_is_forgotten(of_python, zoo):
    for name, pedal in (("slow", 0.2), ("fast", 0.9)):
        (zoo / name / "network.py").unlink()
        driver = DRIVER.replace("import network", "import parts.network as network")
        python_entry(zoo / name, {"driver.py": driver, "parts/network.py": f"PEDAL = {pedal}"})
    assert main(["submit", "zoo/slow", "zoo/fast", "--check"]) == 0
    assert of_python == [0.2, 0.2, 0.9, 0.9]
    assert not {"parts", "parts.network"} & {*sys.modules}


def test_a_package_without_init_of_elsewhere_is_refused(of_python, zoo, capsys, monkeypatch):
    (zoo / "shared" / "parts").mkdir(parents=True)
    monkeypatch.syspath_prepend(zoo / "shared")
    python_entry(zoo / "fast", {"driver.py": f"import parts{DRIVER}"})
    assert main(["submit", "zoo/fast", "--check"]) == 2
    said = f"parts: the driver imports this package from {zoo / 'shared'}; put it into {zoo / 'fast'}, with an __init__"
    assert said in capsys.readouterr().err and "parts" not in sys.modules


@pytest.mark.parametrize("place", ["__pycache__", "parts/__pycache__"])
def test_what_the_seed_does_not_follow_from_is_not_there(of_python, zoo, capsys, place):
    """A driver that reads a file which no hash covers could change behind it."""
    (zoo / "fast" / place).mkdir(parents=True)
    (zoo / "fast" / place / "weights").touch()
    python_entry(zoo / "fast", {"driver.py": f"open('{place}/weights'){DRIVER}"})
    assert main(["submit", "zoo/fast", "--check"]) == 2
    assert f"No such file or directory: '{place}/weights'" in capsys.readouterr().err
    assert of_python == [] and not (zoo / "fast" / "checked.json").exists()


@pytest.mark.parametrize("name", ["__pycache__/x.onnx", "{zoo}/bold/x.onnx", "../bold/x.onnx"])
def test_a_driver_that_is_not_among_the_files_is_refused(zoo, capsys, name):
    name = name.format(zoo=zoo)
    (zoo / "bold" / "__pycache__").mkdir()
    for place in ("x.onnx", "__pycache__/x.onnx"):
        (zoo / "bold" / place).touch()
    change(zoo / "bold" / "results.json", lambda content: content["drivers"][0].update(name=name, kind="file"))
    assert main(["submit", "zoo/bold"]) == 2
    assert f"{name} is not in zoo/bold" in capsys.readouterr().err


def test_a_driver_that_writes_into_its_folder_is_refused(of_python, zoo, capsys):
    python_entry(zoo / "fast", {"driver.py": f"open('log', 'w').close(){DRIVER}"})
    assert main(["submit", "zoo/fast", "--check"]) == 2
    assert "zoo/fast: its files were changed during the check" in capsys.readouterr().err
    assert not (zoo / "fast" / "log").exists() and not (zoo / "fast" / "checked.json").exists()
