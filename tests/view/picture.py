"""Draws docs/view.png: the live view in a grasp. tests/view/picture.py AFFERENT SCENE OUT.png [SECONDS]"""

import signal
import sys

from browser import By, Program, chromium, until


def main():
    afferent, scene, out = sys.argv[1:4]
    seconds = float(sys.argv[4]) if len(sys.argv) > 4 else 7.2
    browser = chromium(1360, 1010)
    try:
        with Program(afferent, "view", scene) as program:
            browser.get(program.url())
            at = "return afferentView.model.last ?? 0"
            until(lambda: browser.execute_script(at) >= 1.6, "the contact")
            browser.find_element(By.TAG_NAME, "body").send_keys("m")
            browser.find_element(By.CSS_SELECTOR, "#marks input").send_keys("contact")
            until(lambda: browser.execute_script(at) >= seconds, "the grasp")
            browser.save_screenshot(out)
            program.end(signal.SIGINT)
    finally:
        browser.quit()


if __name__ == "__main__":
    main()
