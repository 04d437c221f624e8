"""Encounters, braking, near speeds and waiting once more, in plain Python loops, to compare with."""

from __future__ import annotations

import math

from jaxwalk.metrics.braking import ALREADY, NEVER, ONSET, STANDING, UNSEEN


def distance(t, k, e, p):
    return math.hypot(t.ped_x[k, e, p] - t.car_x[k, e], t.ped_y[k, e, p] - t.car_y[k, e])


def closes(t, k, e, p):
    """Within 20 m, and nearer by more than 0.1 m/s, from the derivative of the distance."""
    dx, dy = t.ped_x[k, e, p] - t.car_x[k, e], t.ped_y[k, e, p] - t.car_y[k, e]
    vx = t.ped_vx[k, e, p] - t.car_speed[k, e] * t.car_cos[k, e]
    vy = t.ped_vy[k, e, p] - t.car_speed[k, e] * t.car_sin[k, e]
    far = math.hypot(dx, dy)
    return far <= 20 and -(dx * vx + dy * vy) > 0.1 * far + 1e-12


def crossings(t):
    """All (episode, ped, number, type, enter, last)."""
    found = []
    for e in range(len(t.length)):
        for p in range(t.ped_x.shape[2]):
            number, enter = 0, None
            for k in range(t.length[e] + 2):
                on = k <= t.length[e] and t.on_roadway[k, e, p]
                if on and enter is None:
                    number, enter = number + 1, k
                if not on and enter is not None:
                    kind = t.crossing[enter, e, p] or (1 if t.on_crosswalk[enter, e, p] else 2)
                    found.append((e, p, number, kind, enter, k - 1))
                    enter = None
    return found


def encounters(t):
    """All (episode, ped, number, type, enter, start, end, min distance, braking, time)."""
    found = []
    for e, p, number, kind, enter, last in crossings(t):
        start = next((k for k in range(enter, last + 1) if closes(t, k, e, p)), None)
        if start is None:
            continue
        near = min(distance(t, k, e, p) for k in range(start, last + 1))
        found.append((e, p, number, kind, enter, start, last, near, *braking(t, e, enter, last)))
    return found


def braking(t, e, enter, last):
    """What the car did after somebody entered in frame ``enter``; the hold is three steps of 0.1 s."""

    def held_from(k):
        return k >= 1 and k + 2 <= t.length[e] and all(t.car_acceleration[j, e] <= -1 for j in (k, k + 1, k + 2))

    if enter == 0:
        return UNSEEN, math.nan
    if t.car_speed[enter, e] <= 1:
        return STANDING, math.nan
    if any(held_from(k) for k in (enter - 2, enter - 1, enter)):
        return ALREADY, math.nan
    for k in range(enter + 1, last + 1):
        if held_from(k) and t.car_speed[k - 1, e] > 1:
            return ONSET, (k - 1 - enter) * t.dt
    return NEVER, (last - enter) * t.dt


def near_speeds(t):
    """{(episode, type, bin): speeds of frames}, and {(episode, type, bin): mean speeds of encounters}."""
    on_road = {}
    for e, p, number, kind, enter, last in crossings(t):
        on_road |= {(e, p, k): (number, kind) for k in range(enter, last + 1)}
    starts = {(row[0], row[1], row[2]): row[5] for row in encounters(t)}
    pooled, within = {}, {}
    for e in range(len(t.length)):
        for k in range(t.length[e] + 1):
            for kind in (1, 2):
                here = [p for p in range(t.ped_x.shape[2]) if on_road.get((e, p, k), (0, 0))[1] == kind]
                if not here:
                    continue
                near = min(distance(t, k, e, p) for p in here)
                if near >= 12:
                    continue
                pooled.setdefault((e, kind, int(near // 3)), []).append(t.car_speed[k, e])
                for p in here:
                    key = (e, p, on_road[e, p, k][0])
                    if distance(t, k, e, p) == near and key in starts and k >= starts[key]:
                        within.setdefault((key, kind, int(near // 3)), []).append(t.car_speed[k, e])
    by_encounter = {}
    for (key, kind, place), speeds in within.items():
        by_encounter.setdefault((key[0], kind, place), []).append(sum(speeds) / len(speeds))
    return pooled, by_encounter


def kerb_moments(t, distances, speeds, misses):
    """Counts by (episode, setting), (episode, distance bin, miss bin) and (episode, speed bin, miss bin)."""
    names = ("moments", "waits", "distance_moments", "distance_waits", "speed_moments", "speed_waits")
    found = {name: {} for name in names}

    def bin_of(value, lower):
        return max(i for i, edge in enumerate(lower) if value >= edge)

    def count(name, waited, cell):
        for kind in ("moments", "waits")[: 1 + waited]:
            full = f"{name}{kind}"
            found[full][cell] = found[full].get(cell, 0) + 1

    for e in range(len(t.length)):
        for p in range(t.ped_x.shape[2]):
            for k in range(t.length[e]):
                if not (t.at_kerb[k, e, p] and t.enters_roadway[k, e, p]):
                    continue
                waited, far, miss = not t.going[k + 1, e, p], distance(t, k, e, p), t.predicted_miss[k, e, p]
                dx, dy = t.ped_x[k, e, p] - t.car_x[k, e], t.ped_y[k, e, p] - t.car_y[k, e]
                ahead, speed = dx * t.car_cos[k, e] + dy * t.car_sin[k, e], t.car_speed[k, e]
                danger = far < 40 and ahead > 0 and speed > 2 and miss < 2.5
                harmless = far >= 40 or ahead < -2.5
                count("", waited, (e, 0 if danger else 1 if harmless else 2))
                if far < 40 and ahead > 0:
                    gap = bin_of(miss, misses)
                    count("distance_", waited, (e, bin_of(far, distances[:-1]), gap))
                    count("speed_", waited, (e, bin_of(speed, speeds[:-1]), gap))
    return found


def time_to_collision(t, k, e, p, radius):
    """When centres will be ``radius`` apart, from the chord that the relative path cuts off the disc."""
    dx, dy = t.ped_x[k, e, p] - t.car_x[k, e], t.ped_y[k, e, p] - t.car_y[k, e]
    vx, vy = relative_velocity(t, k, e, p)
    approach, offset, speed2 = -(dx * vx + dy * vy), dx * vy - dy * vx, vx**2 + vy**2
    if math.hypot(dx, dy) < radius:
        return 0.0
    if approach <= 0 or offset**2 > radius**2 * speed2:
        return math.inf
    return (approach - math.sqrt(radius**2 * speed2 - offset**2)) / speed2


def relative_velocity(t, k, e, p):
    speed = t.car_speed[k, e]
    return t.ped_vx[k, e, p] - speed * t.car_cos[k, e], t.ped_vy[k, e, p] - speed * t.car_sin[k, e]


def conflict_area(t, e, p, enter, start, last, radius):
    """Frames of the car and of the pedestrian in the conflict area; None if the paths never meet."""
    pairs = [
        (abs(j - k), j < k, k, j)
        for k in range(enter, last + 1)
        for j in range(start, t.length[e] + 1)
        if math.hypot(t.ped_x[k, e, p] - t.car_x[j, e], t.ped_y[k, e, p] - t.car_y[j, e]) < radius and abs(j - k) <= 50
    ]
    return min(pairs)[:1:-1] if pairs else None


def walked(x, y, first, last):
    return sum(math.hypot(x[k + 1] - x[k], y[k + 1] - y[k]) for k in range(first, last))


def smallest_t2(t, e, p, start, car, ped):
    """Distance left over speed, of whoever comes second, until the first is there."""
    times = [math.inf]
    for k in range(start, min(car, ped) + 1):
        if car > ped:
            left, speed = walked(t.car_x[:, e], t.car_y[:, e], k, car), t.car_speed[k, e]
        else:
            left = walked(t.ped_x[:, e, p], t.ped_y[:, e, p], k, ped)
            speed = math.hypot(t.ped_vx[k, e, p], t.ped_vy[k, e, p])
        times.append(0.0 if left == 0 else left / speed if speed > 0 else math.inf)
    return min(times)


def surrogates(t, radius=1.5):
    """All (ttc, exposed time, pet, t2, drac, impact speed, relative speed) of the encounters."""
    found = []
    for e, p, _, _, enter, start, last, *_ in encounters(t):
        ttcs = [time_to_collision(t, k, e, p, radius) for k in range(start, last + 1)]
        speeds = [math.hypot(*relative_velocity(t, k, e, p)) for k in range(start, last + 1)]
        dracs = [
            0.0 if ttc == math.inf else v**2 / (2 * v * ttc) for v, ttc in zip(speeds, ttcs, strict=True) if ttc > 0
        ]
        area = conflict_area(t, e, p, enter, start, last, radius)
        pet, t2 = math.nan, math.nan
        if area is not None:
            pet, t2 = (area[0] - area[1]) * t.dt, smallest_t2(t, e, p, start, *area)
        touch = t.touched[e, p] and last == t.length[e]
        impact = t.car_speed[last, e] if touch and t.car_speed[last, e] >= 0.5 else math.nan
        exposed = sum(ttc < 1.5 for ttc in ttcs) * t.dt
        row = min(ttcs), exposed, pet, t2, max(dracs, default=math.nan), impact, speeds[-1] if touch else math.nan
        found.append([value if math.isfinite(value) else math.nan for value in row])
    return found
