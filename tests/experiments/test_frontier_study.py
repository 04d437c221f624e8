"""The frontier, very small: who plays, what is kept, and that it goes on where it was stopped."""

from __future__ import annotations

import io
import json
from dataclasses import asdict, replace

import pytest
from rich.console import Console

from jaxwalk.evaluation import evaluate
from jaxwalk.evaluation.reading import DocumentError
from jaxwalk.experiments import frontier_study as module
from jaxwalk.experiments.frontier_study import FrontierEffort, FrontierWork, entrants, frontier_study
from jaxwalk.policies.knobs import KNOBS
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import RunError

PLAN = FrontierEffort(
    episodes=8, seed=77, suites=("paper",), drivers=("route-follower", "clearance"), shields=("predictive",)
)
FILES = ["00-route-follower.json", "01-route-follower+predictive.json", "02-clearance-1-m.json"]


def test_who_plays():
    plan = replace(PLAN, drivers=("co-trained", "clearance", "town+rss", "clearance"), shields=("rss", "cbf"))
    names = [(one.contender.name, one.contender.family) for one in entrants(plan)]
    turned = [(KNOBS["clearance"].label("clearance", x), "clearance") for x in KNOBS["clearance"].settings]
    bare = [(name, "co-trained") for name in ("co-trained", "co-trained+rss", "co-trained+cbf")]
    assert names == [*bare, *turned, ("town+rss", "town+rss")]
    own = [one.contender.name for one in entrants(replace(plan, own_settings=True))]
    assert own == ["co-trained", "co-trained+rss", "co-trained+cbf", "clearance", "town+rss"]
    everybody = entrants(FrontierEffort())
    assert len({one.contender.name for one in everybody}) == len(everybody) == 40 + 4 * 5


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The folder, the page, what was said, by a second time too, and how often somebody drove."""
    folder, said, driven = tmp_path_factory.mktemp("frontier") / "out", (io.StringIO(), io.StringIO()), []

    def watched(street, policies, source):
        driven.append(policies["driver"])
        return evaluate(street, policies, source, batch=PLAN.episodes)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "evaluate", watched)
        patch.setitem(KNOBS, "clearance", replace(KNOBS["clearance"], settings=(1.0,)))
        for number, file in enumerate(said):
            page = frontier_study(folder, PLAN, console=Console(file=file, width=200))
            if number == 0:
                (folder / "scores" / "paper" / FILES[2]).unlink()
        broken = folder / "scores" / "paper" / FILES[0]
        text = broken.read_text()
        broken.write_text(text.replace('"goals"', '"gaols"'))
        with pytest.raises(DocumentError, match=r"00-route-follower.json: damaged \(scores.0.goals: Field required\)"):
            frontier_study(folder, PLAN, console=Console(file=io.StringIO()))
        broken.write_text(text)
    return folder, page.read_text(encoding="utf-8"), [file.getvalue() for file in said], driven


def test_everybody_plays_the_same_scenarios(made):
    folder, page, *_ = made
    document = json.loads((folder / "frontier.json").read_text())
    (suite,) = document["suites"]
    assert [one["contender"]["name"] for one in suite["scores"]] == [
        "route-follower", "route-follower+predictive", "clearance 1 m",
    ]  # fmt: skip
    assert {len(one["delays"]) for one in suite["scores"]} == {8}
    assert {path.name for path in (folder / "scores" / "paper").iterdir()} == set(FILES)
    assert document["drivers"][0] == {"name": "route-follower", "kind": "rule", "sha256": None}
    assert "# Contacts against delay" in page and "cannot be judged against" in page
    assert (folder / "frontier-paper.svg").is_file()


def test_it_says_what_there_is_to_play_and_goes_on(made):
    _, _, (first, second), driven = made
    assert "3 drivers, 1 suite, 8 scenarios each: 24 episodes, 0 of them there already" in first
    assert "paper: clearance 1 m; 3 of 3" in first
    assert "24 episodes, 16 of them there already" in second
    assert "paper: clearance 1 m; 1 of 1" in second and "predictive;" not in second
    assert len(driven) == 4, "three, and the one whose file was deleted"


def test_another_plan_needs_another_folder(made, quiet):
    with pytest.raises(RunError, match="was begun with another value of episodes"):
        frontier_study(made[0], replace(PLAN, episodes=9), console=quiet)


def test_a_folder_of_an_older_version_goes_on_as_it_began(tmp_path, quiet):
    older = {name: value for name, value in asdict(PLAN).items() if name != "own_settings"}
    (tmp_path / "plan.json").write_text(json.dumps(older))
    with pytest.raises(RunError, match="was begun with another value of own_settings"):
        frontier_study(tmp_path, replace(PLAN, own_settings=True), console=quiet)
    FrontierWork(tmp_path, PLAN, quiet, RECIPES["fast"]).do([])
    assert json.loads((tmp_path / "plan.json").read_text())["own_settings"] is False
