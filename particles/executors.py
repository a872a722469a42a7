"""Running the configurations of a run one after the other: in threads, or on an executor."""

from _thread import start_new_thread
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Executor
from itertools import islice
from queue import SimpleQueue

from particles.configuration import Arrays, run_configuration
from particles.plan import Plan

#: Blocks of configurations that are submitted to an executor. Chosen: each costs a message, and
#: this is many for a pool of a few dozen processes.
BLOCKS = 64
#: Configurations that may be ahead of their turn, for each thread. The origin of the number is not
#: recorded.
AHEAD_PER_THREAD = 4


def run_in_threads(plan: Plan, configurations: range, workers: int) -> Iterator[Arrays]:
    """Run configurations in so many threads; yield their results in order.

    Also with one thread: while compiled code runs in the main thread, Python sees no Ctrl-C. After
    an exception nobody waits for the threads, as a pool of concurrent.futures would. Queues written
    in C are all that is shared: an exception that a signal raises inside a lock of `threading` may
    leave it locked for ever.
    """
    requests: SimpleQueue[int | None] = SimpleQueue()
    replies: SimpleQueue[tuple[int, Arrays | BaseException | None]] = SimpleQueue()
    stopped: list[bool] = []

    def work() -> None:
        while (configuration := requests.get()) is not None and not stopped:
            try:
                replies.put((configuration, run_configuration(plan, configuration)))
            except BaseException as error:  # it is raised again in the main thread
                replies.put((configuration, error))
        replies.put((-1, None))

    results: dict[int, Arrays | BaseException | None] = {}
    upcoming = iter(configurations)
    try:
        for _ in range(workers):
            start_new_thread(work, ())
        for configuration in islice(upcoming, AHEAD_PER_THREAD * workers):
            requests.put(configuration)
        for configuration in configurations:
            while configuration not in results:
                results.update((replies.get(),))
            result = results.pop(configuration)
            if isinstance(result, BaseException):
                raise result
            for following in islice(upcoming, 1):
                requests.put(following)
            assert result is not None
            yield result
    except BaseException:
        stopped.append(True)
        raise
    finally:
        for _ in range(workers):
            requests.put(None)
    for _ in range(workers):
        replies.get()


def run_in_executor(executor: Executor, plan: Plan, configurations: range) -> Iterator[Arrays]:
    """Submit configurations in BLOCKS or so; yield their results in order."""
    size = max(1, len(configurations) // BLOCKS)
    starts = range(0, len(configurations), size)
    blocks = [configurations[start : start + size] for start in starts]
    pending = deque(executor.submit(_run_block, plan, block) for block in blocks)
    try:
        while pending:
            yield from pending.popleft().result()
    finally:
        for future in pending:
            future.cancel()


def _run_block(plan: Plan, block: range) -> list[Arrays]:
    return [run_configuration(plan, configuration) for configuration in block]
