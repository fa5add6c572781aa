"""`sigmafmu realtime --view`: what a browser gets while a run goes on, by a client of our own and in Chromium."""

import http.client
import json
import threading
from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from research.browser import Browser, MissingError
from sigmafmu import SigmafmuError, realtime
from sigmafmu.cli import app
from sigmafmu.view import live as module
from sigmafmu.view.subject import model_of, scene_of_fmu

RATE, DURATION = 500.0, 0.6


@pytest.fixture(scope="module")
def top(viewer):
    model = model_of("HeavyTop")
    return model, scene_of_fmu(model.fmu)


def get(address: str, path: str, host: str | None = None) -> http.client.HTTPResponse:
    place = address.removeprefix("http://").rstrip("/")
    connection = http.client.HTTPConnection(place, timeout=30)
    connection.request("GET", path, headers={"Host": host or place})
    return connection.getresponse()


def frames(response: http.client.HTTPResponse) -> list[dict]:
    """All events until the end."""
    text = response.read().decode()
    assert text.endswith("event: end\ndata: \n\n")
    return [json.loads(line.removeprefix("data: ")) for line in text.splitlines() if line.startswith("data: {")]


def test_frames_are_the_motion(top):
    """Those of an instance that is stepped alike, as the same bits; the run waits for the one who looks."""
    model, scene = top
    answers, seen = {}, []

    def look(address):
        answers["page"] = get(address, "/")
        answers["page"] = answers["page"].status, answers["page"].read().decode()
        for path, host in (("/other", None), ("/", "example.org")):
            answers[path, host] = get(address, path, host).status
        seen.extend(frames(get(address, "/events")))

    clients = []

    def opening(address):
        clients.append(threading.Thread(target=look, args=(address,)))
        clients[0].start()

    latency = realtime.run(model, RATE, DURATION, live=partial(module.live, scene, opening=opening))
    clients[0].join()
    assert len(latency.duration) == len(latency.delay) == round(RATE * DURATION)
    status, text = answers["page"]
    assert status == 200
    assert '"live":true' in text
    assert "connect-src 'self'" in text
    assert (answers["/other", None], answers["/", "example.org"]) == (404, 403)

    each = round(RATE / realtime.FRAMES_PER_SECOND)
    assert [frame["frame"] for frame in seen] == list(range(len(seen)))
    assert len(seen) == 1 + -(-round(RATE * DURATION) // each)
    names = [*(f"top.position[{i}]" for i in (1, 2, 3)), *(f"top.quaternion[{i}]" for i in (1, 2, 3, 4))]
    with model.instance() as instance:
        instance.start()
        expected = [[instance.get(name) for name in names]]
        for i in range(round(RATE * DURATION)):
            instance.step(1 / RATE)
            if (i + 1) % each == 0 or i + 1 == round(RATE * DURATION):
                expected.append([instance.get(name) for name in names])
    found = np.array([frame["poses"][0] for frame in seen])
    assert np.abs(found[:, :3] - np.array(expected)[:, :3]).max() < 1e-12
    q, reference = found[:, 3:], np.array(expected)[:, 3:]
    assert np.abs(np.abs((q * reference).sum(axis=1)) - 1).max() < 1e-12  # q and -q are the same


def test_steps_keep_the_pace_over_all_frames(top):
    """Steps start when they are due from the beginning on, not from the last frame on."""
    model, scene = top
    found = realtime.run(
        model,
        RATE,
        DURATION,
        live=partial(
            module.live,
            scene,
            opening=lambda address: threading.Thread(target=lambda: frames(get(address, "/events"))).start(),
        ),
    )
    assert (found.delay >= 0).all()
    assert np.median(found.delay) < 0.5 / RATE


def test_without_a_browser_it_ends_with_a_sentence(top, monkeypatch):
    model, scene = top
    monkeypatch.setattr(module, "PATIENCE", 0.1)
    with pytest.raises(SigmafmuError, match=r"^no browser has opened http://127\.0\.0\.1:\d+/ within 0\.1 s$"):
        realtime.run(model, RATE, DURATION, live=partial(module.live, scene, opening=lambda _: None))


def test_command(top, monkeypatch):
    model, _ = top
    seen = []

    def opened(address):
        seen.append(threading.Thread(target=lambda: frames(get(address, "/events"))))
        seen[-1].start()

    monkeypatch.setattr("webbrowser.open", opened)
    found = CliRunner().invoke(app, ["realtime", model.name, "--rate", "100", "--duration", "0.2", "--view"])
    assert found.exit_code == 0, found.output
    assert "see it at http://127.0.0.1:" in found.output
    assert "HeavyTop at 100 Hz: 20 steps" in found.output
    assert len(seen) == 1


def test_the_page_follows_the_run(top):
    """In Chromium: it shows the end of the run without being asked, and then plays all of it."""
    model, scene = top
    try:
        browser = Browser()
    except MissingError as error:
        pytest.skip(str(error))
    try:
        opening = browser.driver.get
        realtime.run(model, 100.0, 2.0, live=partial(module.live, scene, opening=opening))
        browser.wait("return sigmafmu.state.time > 1.999")
        assert not browser.state["playing"]
        browser.run("sigmafmu.view.motion.moveTo(2)")
        place = browser.run("return sigmafmu.view.motion.poses[0].position.toArray()")
        result = model.run(2.0, step_size=0.01, outputs=["top.position"])
        assert np.abs(np.array(place) - result["top.position"][-1]).max() < 1e-9
        browser.run("sigmafmu.seek(1)")
        place = browser.run("return sigmafmu.view.motion.poses[0].position.toArray()")
        assert np.abs(np.array(place) - result["top.position"][100]).max() < 1e-3  # between two frames
        assert [line for line in browser.log("browser") if "favicon" not in line] == []
    finally:
        browser.driver.quit()
