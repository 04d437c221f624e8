"""How every test runs: array shapes and types are checked, and what was compiled once is kept for the next run."""

from __future__ import annotations

import gc
import hashlib
import io
import os
import platform
import signal
from dataclasses import replace
from pathlib import Path

import jaxtyping._import_hook
import pytest
from rich.console import Console

from quickly import QUICKLY

SOURCE = Path(__file__).parents[1] / "src"
SHAPED = [
    ".".join(file.relative_to(SOURCE).with_suffix("").parts).removesuffix(".__init__")
    for file in (SOURCE / "jaxwalk").rglob("*.py")
    if "from jaxtyping import" in file.read_text()
]
"""Modules that state shapes. Pyright checks the types of the others; checking each call took a third of their time."""


class Outermost(jaxtyping._import_hook.JaxtypingTransformer):
    """Checks functions of modules and classes. One inside another would be given its checks anew at each call.

    jaxtyping has no option for it, so this replaces a class of its own (`tests/test_shape_checks.py`).
    """

    def visit_FunctionDef(self, node):
        body, node.body = node.body, []
        super().visit_FunctionDef(node)
        node.body = body
        return node


jaxtyping._import_hook.JaxtypingTransformer = Outermost
jaxtyping.install_import_hook(SHAPED, "beartype.beartype")  # before the first import of jaxwalk

os.environ.update(QUICKLY)

SMALL = {"environments": 8, "steps": 8, "minibatches": 2, "updates": 6}
"""A training so small that its time is all compiling, which is done once."""


def pytest_addoption(parser):
    parser.addoption(
        "--compile-report",
        type=int,
        nargs="?",
        const=30,
        default=0,
        metavar="N",
        help="list the N (30) files and tests that cost most",
    )
    parser.addoption("--part", metavar="K/N", help="run only part K of N of the long tests")


def pytest_configure(config):
    import jax

    from compiling import Recorder, Relief

    gc.set_threshold(400_000, 20, 20)  # tracing makes millions of objects that stay; looking for garbage took a tenth
    config.pluginmanager.register(Recorder(config.getoption("compile_report")), "compiling")
    config.pluginmanager.register(Relief(), "relief")

    jax.config.update("jax_num_cpu_devices", 2)  # so that environments can be shared out, on any machine
    # Two workers may meet in the cache; a half-written entry is compiled anew.
    config.addinivalue_line("filterwarnings", "ignore:Error (reading|writing) persistent compilation:UserWarning")
    if getattr(config, "cache", None) is not None:
        jax.config.update("jax_compilation_cache_dir", str(config.cache.mkdir(f"jax-{_processor()}")))
        jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)


LARGE = ("test_house.py", "testing", "experiments")
"""What needs most memory at once: workers begin with it, while they are small."""
LONG = ("cli", "learning", "evaluation", "browser", "runs", "sim", "adapters", "policies", "metrics")
"""Folders of tests that take long, the longest first; they come next."""


def pytest_collection_modifyitems(config, items):
    """Long rooms early, so that no worker waits for another one in the end; only the part that is asked for."""
    rank = {room: number for number, room in enumerate((*LARGE, *LONG))}
    items.sort(key=lambda item: rank.get(_room(item.nodeid), len(rank)))
    if config.getoption("part"):
        part, parts = map(int, config.getoption("part").split("/"))
        units = sorted({_unit(item.nodeid) for item in items if item.get_closest_marker("long")})
        chosen = set(units[part % parts :: parts])
        config.hook.pytest_deselected(items=[item for item in items if _unit(item.nodeid) not in chosen])
        items[:] = [item for item in items if _unit(item.nodeid) in chosen]


def _unit(nodeid):
    """What stays together in a part: one case of a test with many, or else a file, whose tests share what took long."""
    return nodeid if "[" in nodeid else _file(nodeid)


def _file(nodeid):
    return nodeid.partition("::")[0]


def _room(nodeid):
    return _file(nodeid).split("/")[1]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """A room goes to one worker, so that its fixtures and programs are made once; to many workers, a file does."""
    from xdist.scheduler import LoadScopeScheduling

    if config.getoption("dist") != "load":
        return None
    few = (config.getoption("numprocesses") or 1) <= 4

    class ByRoom(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return _room(nodeid) if few else _file(nodeid)

    config.option.loadscopereorder = False
    return ByRoom(config, log)


def _processor() -> str:
    """A short name for this machine's instruction set: compiled code from another one might not run here."""
    about = Path("/proc/cpuinfo")
    flags = next((x for x in about.read_text().splitlines() if x.startswith("flags")), "") if about.exists() else ""
    return hashlib.sha256(f"{platform.machine()} {platform.processor()} {flags}".encode()).hexdigest()[:8]


@pytest.fixture(scope="session", autouse=True)
def strict_processes():
    """Processes that tests start also turn warnings into errors."""
    with pytest.MonkeyPatch.context() as patch:
        cache = [f"ignore:Error {doing} persistent compilation:UserWarning" for doing in ("reading", "writing")]
        patch.setenv("PYTHONWARNINGS", ",".join(["error", *cache]))
        yield


@pytest.fixture(scope="module")
def lenient_processes():
    """Processes of other libraries may warn: Ray's do on Python 3.14."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("PYTHONWARNINGS", raising=False)
        yield


@pytest.fixture(scope="session", autouse=True)
def interruptible():
    """Processes that tests start hear SIGINT, also if a shell runs the tests in the background, where it is ignored."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


AT_ONCE, REPLAYED = 16, 4
"""Episodes that evaluations of tests play at once, and collisions that they replay: many more than most of them ask
for, badly compiled, take long."""
READERS = ("evaluation.batches", "cli.evaluate")
"""Modules that know how many episodes are played at once."""


@pytest.fixture(scope="session", autouse=True)
def small_batches():
    """Evaluations play a few episodes at once."""
    import jaxwalk.evaluation

    assert jaxwalk.evaluation.BATCH > AT_ONCE  # bound on first use, so before it is patched
    with pytest.MonkeyPatch.context() as patch:
        for module in READERS:
            patch.setattr(f"jaxwalk.{module}.BATCH", AT_ONCE)
        patch.setattr("jaxwalk.evaluation.counterfactual.SMALL_BATCH", REPLAYED)
        yield


@pytest.fixture(scope="module")
def compiled_well():
    """Programs that are first called in this module's tests run for long: they are compiled as users' are."""
    import jax

    jax.config.update("jax_disable_most_optimizations", False)
    yield
    jax.config.update("jax_disable_most_optimizations", True)


@pytest.fixture(scope="session")
def street():
    """The paper's street; nobody is paid."""
    from jaxwalk import Street

    return Street.create()


@pytest.fixture(scope="session")
def draw(street):
    """Gives 256 scenarios, from the global index on."""
    from sim.play import draw

    return lambda first=0, *, domain=0, seed=1: draw(street, seed, domain, first)


@pytest.fixture(scope="session")
def scenarios(draw):
    """256 scenarios."""
    return draw()


@pytest.fixture(scope="module")
def always_go(street, scenarios):
    """Everybody walks for 500 steps; the car stands. 70 MB: each file of tests plays its own."""
    from sim.play import play

    return play(street, scenarios)


@pytest.fixture(scope="module")
def driven(street, scenarios):
    """500 random actions each: the car jerks about, people go or wait. As large, and played as often."""
    from sim.play import play, random_actions

    actions = random_actions(0)
    return actions, play(street, scenarios, *actions)


@pytest.fixture(scope="session")
def paid_street():
    """The paper's street, with weight 1 for every reward term, and every cost."""
    from jaxwalk import Street
    from jaxwalk.sim.cost import DRIVER_COSTS
    from jaxwalk.sim.reward import DRIVER_TERMS, PEDESTRIAN_TERMS

    return Street.create(
        driver_weights=dict.fromkeys(DRIVER_TERMS, 1.0),
        pedestrian_weights=dict.fromkeys(PEDESTRIAN_TERMS, 1.0),
        driver_costs=tuple(DRIVER_COSTS),
    )


@pytest.fixture(scope="session")
def midway(paid_street, scenarios):
    """The state after 150 steps in which everybody walked and the car stood."""
    from sim.play import actions, everything, reset

    state = reset(paid_street, scenarios)
    for _ in range(150):
        state, *_ = everything(paid_street, scenarios, state, actions())
    return state


@pytest.fixture(scope="session")
def tiny():
    """An experiment of 6 updates of 8 environments x 8 steps."""
    from jaxwalk.recipes import RECIPES, with_training

    experiment = RECIPES["fast"]
    roles = {
        name: replace(role, actor_hidden=(8,), critic_hidden=(8,), epochs=1)
        for name, role in experiment.train.roles.items()
    }
    return with_training(experiment, **SMALL, roles=roles)


@pytest.fixture
def quiet():
    """A console that nobody reads."""
    return Console(file=io.StringIO(), width=100)


@pytest.fixture
def scenario_library():
    """What writes OpenSCENARIO and OpenDRIVE; skips the test where it is missing."""
    return pytest.importorskip("scenariogeneration", reason="no scenariogeneration: pip install jaxwalk[scenarios]")


@pytest.fixture(scope="session")
def whole(tiny, tmp_path_factory):
    """The run of an uninterrupted training."""
    from jaxwalk.runs.folder import Run
    from jaxwalk.runs.progress import Display
    from jaxwalk.runs.training import train_in

    run = Run.create(tmp_path_factory.mktemp("runs") / "whole", tiny)
    train_in(run, display=Display(Console(file=io.StringIO())))
    return run
