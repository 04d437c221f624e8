"""Live: somebody drives by hand, without a server; the scenario is saved and played by a rule."""

from pathlib import Path

from jaxwalk.live.live_offer import offer_of
from jaxwalk.live.live_session import LiveSession
from jaxwalk.runs.contestants import contestant
from jaxwalk.sim.suites import Where

offer = offer_of(["route-follower"], ["always-go"], Where(("paper",)))
session = LiveSession(offer, Path("runs/live"), contestant)
session.open(offer.start)
session.hand = (1.0, 0.5, float("nan"))  # a person drives, with half throttle, along the route
speeds = [session.step()["car"][3] for _ in range(20)]
session.hand = (1.0, -1.0, float("nan"))  # and brakes
while speeds[-1] > 0:
    speeds.append(session.step()["car"][3])
print(
    f"up to {max(speeds):.1f} m/s and down again in {len(speeds) * session.dt:.1f} s; {session.save()} has the scenario"
)
