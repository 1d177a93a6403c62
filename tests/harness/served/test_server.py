"""`cosimo explore` of scenes with FMUs of others: a process that only this machine may ask, and its page in a browser."""

import json
import signal
import subprocess
import sys
import urllib.error
import urllib.request

import pytest
from cosimo.tests.harness.report.test_in_browser import browser  # noqa: F401

pytest.importorskip("uvicorn")
WAIT = 60_000  # ms: a busy machine
TWO = """
title = "One FMU drives another"
stop_time = 1.0
connections = ["first.x -> second.u"]
[units.first]
fmu = "{fmu}"
[units.second]
fmu = "{fmu}"
[master]
step = 0.01
"""


@pytest.fixture(scope="module")
def address(foreign, tmp_path_factory):
    """Of a scene of two FMUs that another maker has written."""
    folder = tmp_path_factory.mktemp("served")
    (folder / "two.toml").write_text(TWO.format(fmu=foreign()))
    command = [sys.executable, "-m", "cosimo.orchestrator.cli", "explore", "two.toml", "--no-browser"]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    yield process.stdout.readline().split()[0].rstrip("/")
    process.send_signal(signal.SIGINT)
    _, messages = process.communicate(timeout=60)
    assert "Traceback" not in messages
    assert process.returncode == 130


def asked(address, action, headers=(), **content):
    request = urllib.request.Request(
        f"{address}/{action}", json.dumps(content).encode(), {"content-type": "application/json", **dict(headers)}
    )
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, json.loads(answer.read())
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def test_requests_step_the_scene_and_refuse_with_one_message(address):
    assert asked(address, "begin", values={"first.limit": 1e6})[0] == 200
    assert asked(address, "advance", to=0.5, names=["second.y"])[1]["time"] == 0.5
    assert asked(address, "move", name="first.u", value=2.0) == (200, None)
    status, answer = asked(address, "advance", to=9.0, names=["first.x"])
    assert (status, answer["done"], answer["time"]) == (200, True, 1.0)
    assert answer["rows"][-1] == pytest.approx([1.0])  # the integral of 2 over the second half
    status, text = asked(address, "move", name="second.u", value=1.0)
    assert status == 422
    assert "nothing drives" in text
    with urllib.request.urlopen(f"{address}/signals.csv") as file:
        assert file.read().decode().splitlines()[0].startswith("time [s],first.x")


def test_only_this_machine_and_this_page_are_answered(address):
    assert asked(address, "begin", [("host", "elsewhere.example")], values={})[0] == 400
    assert asked(address, "begin", [("content-type", "text/plain")], values={})[0] == 415
    assert asked(address, "close")[0] == 404


@pytest.mark.full
def test_the_page_moves_an_input_and_shows_errors(address, browser):  # noqa: F811
    page = browser.new_page()
    failed = []
    page.on("pageerror", lambda error: failed.append(str(error)))
    page.on("console", lambda message: failed.append(message.text) if message.type == "error" else None)
    page.goto(address + "/")
    page.wait_for_selector("body[data-ready]", timeout=WAIT)
    page.fill('[id="value-first.u"]', "3")
    page.keyboard.press("Tab")
    page.select_option("#pace", "0")
    page.click("#run")
    page.wait_for_function("document.getElementById('status').textContent.includes('done')", timeout=WAIT)
    drawn = page.evaluate("document.querySelector('#curves .plot').data.map(c => [c.name, c.y[c.y.length / 2]])")
    assert dict(drawn)["first.x"] == pytest.approx(3.0)
    assert page.evaluate("document.querySelector('#curves .plot').calcdata[0].length") > 50  # drawn, not only held
    page.click("#errors")
    page.wait_for_selector("#table:not([hidden])", timeout=WAIT)
    assert page.locator("#table tbody tr").count() == 6
    assert failed == []
    page.close()
