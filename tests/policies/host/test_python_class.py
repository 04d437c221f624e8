from __future__ import annotations

import sys
from importlib import import_module

import jax.numpy as jnp
import pytest

from jaxwalk.policies.host import DriverError, is_host_driver, load_host_driver
from jaxwalk.policies.host.borrowed_modules import modules_of

SOURCE = """
import dataclasses
from neighbour import THROTTLE

@dataclasses.dataclass
class Mine:
    throttle: float = THROTTLE
    observes = "route"
    def act(self, observation):
        return [[self.throttle, 0.0]] * len(observation)

class Plain:
    def act(self, observation):
        return observation[:, :2]

class Lost(Plain):
    observes = "everything"

class Broken(Plain):
    def __init__(self):
        raise KeyError("weights")

class Needy(Plain):
    def __init__(self, weights):
        pass

class Idle:
    observes = "route"

class Blind(Plain):
    @property
    def observes(self):
        raise KeyError("eyes")

class Restless(Plain):
    @property
    def reset(self):
        raise KeyError("rest")

class Late(Plain):
    looked = 0
    @property
    def act(self):
        self.looked += 1
        if self.looked > 1:
            raise KeyError("late")
        return print

NUMBER = 3
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    (tmp_path / "my_drivers.py").write_text(SOURCE)
    (tmp_path / "neighbour.py").write_text("THROTTLE = 0.5")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delitem(sys.modules, "my_drivers", raising=False)
    monkeypatch.delitem(sys.modules, "neighbour", raising=False)
    return tmp_path


@pytest.mark.parametrize("home", ["my_drivers", "my_drivers.py", "{place}/my_drivers.py"])
def test_a_class_is_found_in_a_module_or_a_file(place, home):
    name = home.format(place=place) + ":Mine"
    assert is_host_driver(name)
    driver = load_host_driver(name)
    assert (driver.name, driver.view.name) == (name, "route")
    assert driver.act(None, None, jnp.zeros((59, 2)))[0].tolist() == [[0.5, 0.5], [0.0, 0.0]]


def test_installed_modules_stay_and_those_of_the_folder_are_forgotten(place, monkeypatch):
    """Another folder's driver may have a neighbour of the same name; ``sched`` is one of Python's own."""
    monkeypatch.delitem(sys.modules, "sched", raising=False)
    monkeypatch.syspath_prepend(place)
    with modules_of(place, place) as check:
        assert import_module("neighbour").THROTTLE == 0.5
        import_module("sched")
        check()
    assert "sched" in sys.modules and "neighbour" not in sys.modules


def test_without_observes_it_is_paper(place):
    assert load_host_driver("my_drivers:Plain").view.name == "paper"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("nowhere:Mine", "nowhere:Mine: importing nowhere raised ModuleNotFoundError"),
        ("nowhere.py:Mine", "importing nowhere.py raised FileNotFoundError: no file nowhere.py"),
        ("my_drivers:Yours", "my_drivers has no class Yours"),
        ("my_drivers:NUMBER", "my_drivers has no class NUMBER"),
        ("my_drivers:Idle", r"has no method act\(observation\)"),
        ("my_drivers:Broken", r"Broken\(\) raised KeyError: 'weights'"),
        ("my_drivers:Needy", r"Needy\(\) raised TypeError"),
        ("my_drivers:Blind", r"looking at what Blind\(\) returned raised KeyError: 'eyes'"),
        ("my_drivers:Restless", r"looking at what Restless\(\) returned raised KeyError: 'rest'"),
        ("my_drivers:Lost", r"observes 'everything', but .* there are: paper \(34\), route \(59\)"),
        ("driver.onnx", "driver.onnx: no such file"),
    ],
)
def test_what_cannot_be_used_is_said(place, name, message):
    with pytest.raises(DriverError, match=message):
        load_host_driver(name)


def test_a_property_that_fails_later_is_the_drivers_fault(place):
    driver = load_host_driver("my_drivers:Late")
    with pytest.raises(DriverError, match=r"my_drivers:Late: act raised KeyError: 'late' \(my_drivers.py, line \d+\)"):
        driver.act(None, None, jnp.zeros((34, 2)))


LEAVING = {
    "import": ("import sys\nsys.exit()", r"code None"),
    "construction": ("class Mine:\n    def __init__(self):\n        raise SystemExit(0)", "code 0"),
    "lookup": ("def __getattr__(name):\n    raise SystemExit('enough')", "code enough"),
}


@pytest.mark.parametrize("when", LEAVING)
def test_a_driver_that_exits_is_refused_and_does_not_end_the_program(tmp_path, when):
    source, code = LEAVING[when]
    file = tmp_path / "leaves.py"
    file.write_text(source)
    with pytest.raises(DriverError, match=rf"leaves\.py:Mine: exits while it is loaded \({code}\); remove the exit"):
        load_host_driver(f"{file}:Mine")


def test_a_limit_must_be_one(place):
    with pytest.raises(DriverError, match="must be above 0 s, not 0"):
        load_host_driver("my_drivers:Plain", seconds=0.0)


@pytest.mark.parametrize("name", ["rule-based", "runs/first", "first.safetensors", "C:/runs/first"])
def test_other_names_are_somebody_elses(name):
    assert not is_host_driver(name)
