"""A headless Chromium that shows a view, for the test and for the picture in the documentation."""

import re
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
# Longer than a busy machine takes for anything.
PATIENCE_S = 120

try:
    from selenium import webdriver
    from selenium.common.exceptions import WebDriverException
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
except ImportError:
    print("skipped: python3-selenium is not installed")
    sys.exit(SKIPPED)


def chromium(width=1360, height=980, dark=False):
    """Chromium from Debian; the program ends as skipped where it is absent."""
    options = webdriver.ChromeOptions()
    # As root it runs without its sandbox, or not at all.
    options.add_argument("--no-sandbox")
    options.add_argument("--headless=new")
    options.add_argument("--disable-gpu")
    options.add_argument("--disable-dev-shm-usage")
    options.add_argument(f"--window-size={width},{height}")
    if dark:
        options.add_argument("--blink-settings=preferredColorScheme=0")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    try:
        browser = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    except (WebDriverException, OSError) as error:
        print(f"skipped: chromium and chromium-driver do not start: {error}")
        sys.exit(SKIPPED)
    browser.set_script_timeout(PATIENCE_S)
    return browser


def until(condition, what):
    """The first value of the condition that is true. Fails after two minutes."""
    limit = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        if time.monotonic() > limit:
            raise AssertionError(f"in vain waited for: {what}")
        time.sleep(0.05)
    return value


class Program:
    """afferent with a view. Its standard error goes to a file, which is read for the address."""

    def __init__(self, program, *arguments, env=None):
        self.said_in = tempfile.NamedTemporaryFile("r", suffix=".err")
        with open(self.said_in.name, "w") as error:
            self.process = subprocess.Popen(
                [program, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=error, env=env
            )

    def said(self):
        with open(self.said_in.name) as file:
            return file.read()

    def url(self):
        def found():
            assert self.process.poll() is None, self.said()
            return re.search(r"^view: (http://\S+)$", self.said(), re.MULTILINE)

        return until(found, "the view's address")[1]

    def end(self, signal=None):
        if signal:
            self.process.send_signal(signal)
        return self.process.wait(PATIENCE_S)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
