"""Programs of ROS 2 as `ros2 launch` starts them, and what has to be gone once they have ended."""

import os
import pathlib
import signal
import subprocess
import time

import yaml

SHARED_MEMORY = pathlib.Path("/dev/shm")


def wait_for(predicate, seconds=10.0, what=None, process=None):
    """Asks until the answer is true and returns it; fails after `seconds` [s].

    `what` is waited for, in words. Where `process` ends meanwhile, its stderr is in the failure.
    """
    end = time.monotonic() + seconds
    while True:
        answer = predicate()
        if answer:
            return answer
        said = what or getattr(predicate, "__doc__", None) or "it"
        if process is not None and process.ended():
            raise AssertionError(f"{process} ended before {said}: {process.stderr()}")
        if time.monotonic() > end:
            told = f": {process.stderr()}" if process is not None else ""
            raise AssertionError(f"after {seconds} s still not: {said}{told}")
        time.sleep(0.005)


def shared_memory():
    """The files that Fast DDS has in shared memory, of all processes of this machine."""
    return {str(path) for path in SHARED_MEMORY.glob("*fast*_*")}


def held_by(pid):
    """The shared memory files that a process has mapped or opened; none if it cannot be asked."""
    held = set()
    try:
        for line in pathlib.Path(f"/proc/{pid}/maps").read_text().splitlines():
            words = line.split(maxsplit=5)
            if len(words) == 6 and words[5].startswith(f"{SHARED_MEMORY}/"):
                held.add(words[5])
        for link in pathlib.Path(f"/proc/{pid}/fd").iterdir():
            held.add(os.readlink(link))
    except OSError:
        pass
    return {path for path in held if path.startswith(f"{SHARED_MEMORY}/")}


def held_by_anybody(except_for=None):
    """Those that some process has mapped or opened, but for one."""
    processes = {path.name for path in pathlib.Path("/proc").glob("[0-9]*")} - {str(except_for)}
    return set().union(*map(held_by, processes))


class Process:
    """One program that runs, its output in files.

    `stop` is how a test ends it; `kill` is for tests of sudden death. What is not ended by the
    test is stopped after it, with the same demands.
    """

    # What others had in shared memory when somebody was killed: who is never told of that, may not
    # be able to remove it.
    _orphans = set()

    def __init__(self, command, folder, label, environment):
        self.label = label
        self.command = [str(word) for word in command]
        self.stdout_path = folder / f"{label}.out"
        self.stderr_path = folder / f"{label}.err"
        self._before = shared_memory()
        with open(self.stdout_path, "wb") as out, open(self.stderr_path, "wb") as err:
            # A group of its own, so that children that outlive it are found.
            self._process = subprocess.Popen(
                self.command, cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                stdout=out, stderr=err, start_new_session=True)

    def __str__(self):
        return f"{self.label} ({' '.join(self.command)})"

    @property
    def pid(self):
        return self._process.pid

    def ended(self):
        """Its exit code if it has ended by itself, as a pair (so that 0 is true), else nothing."""
        code = self._process.poll()
        return None if code is None else (code,)

    def stdout(self):
        return self.stdout_path.read_text(errors="replace")

    def stderr(self):
        return self.stderr_path.read_text(errors="replace")

    def says(self, words, seconds=10.0):
        """Waits until the words are on its stderr."""
        wait_for(lambda: words in self.stderr(), seconds, f"'{words}' said by {self}", self)

    def wait(self, seconds=10.0):
        """Waits until it ends by itself; its exit code."""
        wait_for(self.ended, seconds, f"the end of {self}")
        return self._process.returncode

    def send(self, number):
        self._process.send_signal(number)

    def memory(self):
        """Its resident memory [bytes]."""
        pages = pathlib.Path(f"/proc/{self.pid}/statm").read_text().split()[1]
        return int(pages) * os.sysconf("SC_PAGE_SIZE")

    def stop(self, number=signal.SIGINT, seconds=5.0):
        """Sends the signal; the process has to end with code 0 in time and leave nothing."""
        if self.ended():
            return
        held = held_by(self.pid) - self._before
        self.send(number)
        try:
            self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.kill()
            raise AssertionError(
                f"{self} goes on {seconds} s after signal {int(number)}: {self.stderr()}") from None
        assert self._process.returncode == 0, (
            f"{self} ended with {self._process.returncode}: {self.stderr()}")
        self._assert_group_is_gone()
        # Another process may have opened them; then they are that one's to remove.
        left = {path for path in held if os.path.exists(path)}
        left = left and left - held_by_anybody()
        # The next test is not to find them.
        for path in left:
            pathlib.Path(path).unlink(missing_ok=True)
        left -= self._orphans
        assert not left, f"{self} left in shared memory: {sorted(left)}"

    def kill(self):
        """SIGKILL: no goodbye to anybody; what it leaves in shared memory is removed here."""
        if self.ended():
            return
        held = held_by(self.pid) - self._before
        os.killpg(self.pid, signal.SIGKILL)
        self._process.wait()
        others = held_by_anybody()
        self._orphans |= others
        for path in held - others:
            pathlib.Path(path).unlink(missing_ok=True)

    def _assert_group_is_gone(self):
        try:
            os.killpg(self.pid, 0)
        except ProcessLookupError:
            return
        os.killpg(self.pid, signal.SIGKILL)
        raise AssertionError(f"{self} left a process behind: {self.stderr()}")


def _text(value):
    """A parameter's value as `-p name:=value` takes it: YAML on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, width=10**6)
    return text.strip().removesuffix("...").strip()


class Programs:
    """Starts programs; those that still run at the end of a test are stopped."""

    def __init__(self, folders, work):
        self._folders = folders
        self._work = work
        self._processes = []

    def path(self, executable):
        for folder in self._folders:
            if (folder / executable).exists():
                return folder / executable
        searched = ", ".join(str(folder) for folder in self._folders)
        raise AssertionError(
            f"no {executable} under {searched}: cargo build --workspace --bins --features ros")

    def start(self, executable, *arguments, name=None, namespace=None, parameters=None,
              params_file=None, remap=None, environment=None):
        """Starts a program with the arguments that launch gives: `--ros-args -r … -p …`.

        `parameters`: name → value; `remap`: from → to; `environment`: in place of the tests' own.
        """
        ros = []
        if name is not None:
            ros += ["-r", f"__node:={name}"]
        if namespace is not None:
            ros += ["-r", f"__ns:={namespace}"]
        if params_file is not None:
            ros += ["--params-file", str(params_file)]
        for key, value in (parameters or {}).items():
            ros += ["-p", f"{key}:={_text(value)}"]
        for old, new in (remap or {}).items():
            ros += ["-r", f"{old}:={new}"]
        command = [self.path(executable), *arguments, *(["--ros-args", *ros] if ros else [])]
        label = f"{len(self._processes)}-{executable}"
        all_of_it = {**os.environ, "RUST_BACKTRACE": "1", "ROS_LOG_DIR": str(self._work / "log")}
        all_of_it.update(environment or {})
        process = Process(command, self._work, label, all_of_it)
        self._processes.append(process)
        return process

    def run(self, executable, *arguments, seconds=120.0):
        """A command that ends by itself, with code 0; its stdout."""
        process = self.start(executable, *arguments)
        assert process.wait(seconds) == 0, f"{process}: {process.stderr()}"
        return process.stdout()

    def stop_all(self):
        failures = []
        for process in reversed(self._processes):
            try:
                process.stop()
            except AssertionError as failure:
                failures.append(str(failure))
        assert not failures, "\n".join(failures)

    def end_all(self, seconds=2.0):
        """For the way out after a failure: nothing stays, whatever it says to that."""
        running = [process for process in self._processes if not process.ended()]
        for process in running:
            process.send(signal.SIGINT)
        end = time.monotonic() + seconds
        while time.monotonic() < end and not all(process.ended() for process in running):
            time.sleep(0.01)
        for process in running:
            process.kill()
