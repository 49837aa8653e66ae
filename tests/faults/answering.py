"""A process that answers questions, so that a hang or a crash ends the answer and not the campaign.

    python -m tests.faults.answering MODULE     reads a question a line, and prints what MODULE.answer(question) returns
"""

import importlib
import json
import select
import subprocess
import sys

from tests.launch import ROOT, clean_environment

LIMIT = 20.0    # [s] for one answer
START = 120.0   # [s] until the first question can be asked


class Answering:
    """Asks `answer(question)` of a module, in a process of its own that is started anew after a hang or a crash.

    module : dotted name
    """

    def __init__(self, module):
        self._module, self._process = module, None

    def __enter__(self):
        return self

    def __exit__(self, *fault):
        self._end()

    def ask(self, question):
        """Return (name of the class of the error or None, its text or the answer); ("hang" or "crash", how) without an
        answer."""
        if self._process is None:
            self._start()
        return self._ask(question, LIMIT)

    def _start(self):
        command = [sys.executable, "-m", "tests.faults.answering", self._module]
        self._process = subprocess.Popen(command, cwd=ROOT, env=clean_environment(), text=True, stdin=subprocess.PIPE,
                                         stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        error, said = self._ask(None, START)    # the module is loaded
        if error:
            raise AssertionError(f"{self._module} does not answer: {error}: {said}")

    def _ask(self, question, limit):
        process = self._process
        process.stdin.write(json.dumps(question) + "\n")
        process.stdin.flush()
        if not select.select([process.stdout], [], [], limit)[0]:
            self._end()
            return "hang", f"no end after {limit:g} s"
        line = process.stdout.readline()
        if not line:
            code = process.wait()
            self._end()
            return "crash", f"exit code {code}"
        return tuple(json.loads(line))

    def _end(self):
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process.stdin.close()
            self._process.stdout.close()
            self._process = None


def _answer_all(module):
    answer = importlib.import_module(module).answer
    for line in sys.stdin:
        question = json.loads(line)
        try:
            found = None, None if question is None else answer(question)
        except Exception as error:
            found = type(error).__name__, str(error)
        print(json.dumps(found), flush=True)


if __name__ == "__main__":
    _answer_all(sys.argv[1])
