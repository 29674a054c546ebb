"""A process that is forked while a thread of it plans or compiles can plan itself."""

from __future__ import annotations

import subprocess
import sys

import pytest

#: In a thread: something is in the middle of its work when the process is forked; the child does the same work.
SCRIPT = """
import os, sys, threading, time, warnings
warnings.simplefilter("ignore")  # newer Pythons warn of any fork beside threads
import hognose
from numba.core.compiler_lock import global_compiler_lock

begun, end = threading.Event(), threading.Event()
plain = hognose.load_task("detour")

class Slow(hognose.Task):
    @property
    def spec(self):
        begun.set()
        end.wait()
        return plain.spec

def in_a_property():
    slow = Slow.__new__(Slow)
    type(plain).scene.__get__(slow, Slow)

def while_compiling():
    with global_compiler_lock:
        begun.set()
        time.sleep(0.5)

def in_the_pool():
    hognose.plan(plain)
    begun.set()

work = {work.__name__: work for work in (in_a_property, while_compiling, in_the_pool)}[sys.argv[1]]
thread = threading.Thread(target=work)
thread.start()
begun.wait()
child = os.fork()
if not child:
    good = hognose.plan(hognose.load_task("pipe-tank")).good
    locked = global_compiler_lock._lock.acquire(timeout=60)
    os._exit(0 if good and locked else 1)
code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
end.set()
thread.join()
print(code)
"""


@pytest.mark.parametrize("work", ["in_a_property", "while_compiling", "in_the_pool"])
def test_a_child_that_is_forked_in_the_middle_of_work_can_plan(work):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, work], capture_output=True, text=True, check=False, timeout=300
    )
    assert (done.stdout, done.stderr) == ("0\n", "")
