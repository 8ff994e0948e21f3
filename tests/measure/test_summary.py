"""The metrics of a run: what they count, in any chunks, and how they print."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from gough.measure import Accumulator, Measured, measure

N, TS = 3000, 1e-3


def rows(seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(N) * TS
    q_r = np.stack([0.01 * np.sin(2 * t + k) for k in range(6)], 1)
    return {
        "contour_error": np.abs(rng.normal(size=N)) * 1e-6,
        "orientation_error": np.abs(rng.normal(size=N)) * 1e-5,
        "lag": rng.normal(size=N) * 1e-5,
        "counted": rng.random(N) < 0.8,
        "line": (np.arange(N) // 100).astype(np.int32),
        "q_r": q_r,
        "qd_r": np.stack([0.02 * np.cos(2 * t + k) for k in range(6)], 1),
        "q": q_r + rng.normal(size=(N, 6)) * 1e-6,
        "qd": rng.normal(size=(N, 6)),
        "u": 100 * rng.normal(size=(N, 6)),
        "saturated": (rng.random((N, 6)) < 0.01).astype(np.int8),
    }


def gathered(data, size=N):
    out = Accumulator(TS)
    for k in range(0, N, size):
        out.update(**{name: a[k : k + size] for name, a in data.items()})
    return out


def test_errors_are_those_of_counted_samples():
    data = rows()
    on = data["counted"]
    found = gathered(data).result()
    e = np.where(on, data["contour_error"], 0)
    assert found["contour_error"]["max"] == e.max()
    assert found["contour_error"]["at"] == pytest.approx(np.argmax(e) * TS, rel=1e-15)
    assert found["contour_error"]["line"] == data["line"][np.argmax(e)]
    assert found["contour_error"]["rms"] == pytest.approx(np.sqrt(np.mean(data["contour_error"][on] ** 2)), rel=1e-12)
    assert found["contour_error"]["mean"] == pytest.approx(np.mean(data["contour_error"][on]), rel=1e-12)
    lag = np.abs(data["lag"][on])
    assert found["lag"] == {"max": lag.max(), "rms": pytest.approx(np.sqrt(np.mean(lag**2)), rel=1e-12)}
    error = (data["q_r"] - data["q"])[on]
    assert found["tracking"]["max"] == np.abs(error).max()
    assert found["tracking"]["rms"] == pytest.approx(np.sqrt((error**2).mean(0)).max(), rel=1e-12)
    assert (found["samples"], found["counted"]) == (N, on.sum())


def test_effort_is_that_of_every_sample():
    data = rows()
    found = gathered(data).result()
    assert found["strut_force"]["peak"] == np.abs(data["u"]).max()
    assert found["strut_velocity"]["peak"] == np.abs(data["qd"]).max()
    assert found["saturated"] == data["saturated"].any(1).mean()


@pytest.mark.parametrize("size", [1, 97, 1000])
def test_chunks_of_any_size_give_the_same_numbers(size):
    whole, parts = gathered(rows()), gathered(rows(), size)
    a, b = whole.result(), parts.result()
    for name, value in a.items():
        if isinstance(value, dict):
            assert b[name] == pytest.approx(value, rel=1e-12), name  # sums in another order
        else:
            assert b[name] == value, name
    assert whole.reversals == parts.reversals
    assert len(whole.reversals) == a["reversals"]["count"] > 0


def test_nothing_counted_is_none_and_not_zero():
    data = rows()
    data["counted"][:] = False
    found = gathered(data).result()
    assert found["contour_error"] == dict.fromkeys(("max", "rms", "mean", "at", "line"))
    assert found["reversals"] == {"count": 0, "largest": None}
    json.dumps(found, allow_nan=False)
    assert "0 of 3000 samples" in str(Measured(found))


def test_a_nan_is_told_as_none_and_never_as_a_number():
    data = rows()
    data["contour_error"][1234] = np.nan
    data["counted"][1234] = True
    data["u"][7, 3] = np.nan
    for size in (N, 100):
        found = gathered(data, size).result()
        for name in ("max", "rms", "mean"):
            assert found["contour_error"][name] is None
        assert found["contour_error"]["at"] == pytest.approx(1.234, rel=1e-15)
        assert found["strut_force"]["peak"] is None
        assert found["reversals"]["largest"] is None  # its glitch has the NaN
        json.dumps(found, allow_nan=False)


class FakeLog(dict):
    batch = False
    info: dict = {}
    metrics: dict = {}
    joint_word = "strut"


def test_a_log_with_metrics_is_measured_by_them():
    log = FakeLog()
    log.metrics = {"contour_error": {"max": 1.27e-5, "rms": 1e-6, "mean": 1e-6, "at": 0.5, "line": 12}}
    found = measure(log)
    assert found.contour_error["max"] == 1.27e-5
    assert "12.7 um" in str(found)
    assert "largest contour error at t = 0.5 s, line 12" in str(found)
    with pytest.raises(AttributeError, match="lag was not measured"):
        found.lag  # noqa: B018


def test_a_log_without_metrics_is_measured_from_its_rows():
    data = rows()
    log = FakeLog({"t": np.arange(N) * TS, **{k: v for k, v in data.items() if k not in ("qd", "qd_r")}})
    found, known = measure(log).metrics, gathered(data).result()
    for name in ("contour_error", "orientation_error", "lag", "tracking", "strut_force", "saturated", "counted"):
        assert found[name] == known[name]
    assert found["reversals"]["count"] == known["reversals"]["count"]


def test_a_run_on_the_reference_has_no_error(machine):
    from gough.frames import quaternion_of_abc_np
    from gough.measure import ContourMeter
    from gough.program import CircleDiamondSquare

    motion = CircleDiamondSquare(feed=0.04).plan(machine)
    n = motion.count(1e-3)
    out, meter = Accumulator(1e-3), ContourMeter(motion)
    for k0 in range(0, n, 7000):
        k1 = min(n, k0 + 7000)
        r, book = motion.sample(k0, k1, 1e-3), motion.book(k0, k1, 1e-3)
        c = meter(k0, k1, 1e-3, np.concatenate([r.x[:, :3], quaternion_of_abc_np(r.x[:, 3:])], 1))
        out.update(
            contour_error=c.contour_error,
            orientation_error=c.orientation_error,
            lag=c.lag,
            counted=book.counted,
            line=book.line,
            q_r=r.q,
            qd_r=r.qd,
            q=r.q,
            qd=r.qd,
        )
    found = out.result()
    assert found["contour_error"]["max"] < 1e-15
    assert found["tracking"]["max"] == 0
    assert found["strut_velocity"]["peak"] == pytest.approx(0.3, rel=1e-9)  # the rapid
    assert found["strut_force"]["peak"] is None
    assert SimpleNamespace(**found).counted < n
