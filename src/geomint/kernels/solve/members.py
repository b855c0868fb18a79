"""Steps of many motions: each takes its own, to its own end, and eight of them may be one vector.

A stepper that works lane by lane takes a step of eight motions at once, by the same operations in the
same order as of one: their bits are those of single runs, whatever company they have. Other steppers
take one motion after the other here, as compiled code too, so that threads share the work.
"""

import functools

from ..compiling.bound import Bound
from ..compiling.number_types import SCALAR, NumberType
from ..compiling.recorded import Recorded, helper, inlined
from ..compiling.signatures import MEMORY, PARAMS, Functions, OfType, of_header
from ..numbers.blocks import as_singles, part
from ..numbers.lanes import LANES
from .status import OK

OPEN, ENDED, FAILED = 0.0, 1.0, 2.0  # what is known of a member
AT_ONCE = 4096  # steps between which Ctrl-C is seen


@functools.cache
def members_loop(width: int) -> Recorded:
    """Return the loop over members, `width` of them at once."""

    @inlined
    def singles(block):
        return as_singles(block) if width > 1 else block

    @helper
    def load(values, first: int, here: int, rows: int, own):
        """Write rows of members into lanes; lanes that have none repeat the last member."""
        for lane in range(width):
            at = (first + min(lane, here - 1)) * rows
            for r in range(rows):
                own[width * r + lane] = values[at + r]

    @helper
    def store(own, lane: int, values, at: int, rows: int):
        for r in range(rows):
            values[at + r] = own[width * r + lane]

    @helper
    def members(
        advance, functions, params, coefficients, fractions, memory, work, times, moved, starts,
        lasts, lengths, counts, rests, states, saved, found, stop, carries, rows: int, every: int,
        saves: int,
    ):  # fmt: skip
        """Move members to their ends.

        Parameters
        ----------
        times : block, shape (2,)
            Room for times and steps.
        moved : block
            Parameters of each member, none where all have the same.
        starts, lasts, lengths, counts, rests : block
            Of each member the time it begins at, and from which its last step is counted, its step, how
            many, and the length of a last partial step, 0 for none. Members are in the order of
            `counts`, the largest first.
        states : block
            Of each member, where it is.
        saved : block
            Of each member room for `saves` states, of which every `every`-th is written; 0: none.
        found : block
            What is known of each member: `ENDED`, or `FAILED` where a step of the vector that it is in
            failed, which says nothing of it alone; after `stop` `OPEN`.
        stop : block, shape (1,)
            Not 0 from another thread: end here.
        carries : block
            Scratch, for `width` carries of sums.
        """
        own, clocks, given = singles(memory), singles(times), singles(params)
        moving = len(moved) // max(len(counts), 1)
        for group in range(0, len(counts), width):
            here = min(width, len(counts) - group)
            for i in range(len(own)):
                own[i] = 0.0
            load(states, group, here, rows, own)
            load(starts, group, here, 1, clocks)
            load(lengths, group, here, 1, part(clocks, width, width))
            if moving > 0:
                load(moved, group, here, moving, given)
            done, left, status = 0, here, OK
            while left > 0 and status == OK:
                shortest = int(counts[group + left - 1])
                ahead = min(max(shortest - done - 1, min(shortest - done, 1)), AT_ONCE)
                if every > 0:
                    ahead = min(ahead, every - done % every)
                for lane in range(here):
                    if done + 1 == int(counts[group + lane]):
                        clocks[lane] = lasts[group + lane]
                if ahead > 0:
                    if stop[0] != 0.0:
                        for k in range(group, group + here):
                            found[k] = OPEN
                        return
                    status = advance(
                        functions, params, coefficients, fractions, memory, work, rows, times[0],
                        times[1], done, ahead, done + ahead + 1, memory, part(fractions, 0, 0),
                    )[0]  # fmt: skip
                    done += ahead
                    if status == OK and every > 0 and done % every == 0:
                        for lane in range(left):
                            at = (group + lane) * saves + done // every - 1
                            store(own, lane, saved, at * rows, rows)
                while left > 0 and status == OK and int(counts[group + left - 1]) == done:
                    left -= 1
                    store(own, left, states, (group + left) * rows, rows)
                    store(part(own, width * rows, width * rows), left, carries, left * rows, rows)
                    found[group + left] = ENDED
            cut = 0
            for k in range(group, group + here):
                if found[k] != ENDED:
                    found[k] = FAILED
                elif rests[k] != 0.0:
                    cut += 1
            if cut > 0:
                for i in range(len(own)):
                    own[i] = 0.0
                load(states, group, here, rows, own)
                load(carries, 0, here, rows, part(own, width * rows, width * rows))
                load(rests, group, here, 1, part(clocks, width, width))
                for lane in range(width):
                    k = group + min(lane, here - 1)
                    clocks[lane] = starts[k] + lengths[k] * counts[k]
                status = advance(
                    functions, params, coefficients, fractions, memory, work, rows, times[0],
                    times[1], 0, 1, 2, memory, part(fractions, 0, 0),
                )[0]  # fmt: skip
                for lane in range(here):
                    k = group + lane
                    if found[k] == ENDED and rests[k] != 0.0:
                        if status == OK:
                            store(own, lane, states, k * rows, rows)
                        else:
                            found[k] = FAILED

    return members


def members_sweep(kernel: Bound, functions: tuple[Bound, ...], numbers: NumberType) -> Bound:
    """Return the loop for a stepper's loop and the functions that it takes, in such numbers."""
    loop = members_loop(1 if numbers is SCALAR else LANES)
    taken = of_header(
        loop,
        advance=kernel.signature,
        functions=Functions(tuple(f.signature for f in functions)),
        params=OfType(PARAMS, numbers),
        **dict.fromkeys(("memory", "work", "times"), OfType(MEMORY, numbers)),
    )
    return Bound(loop, taken)
