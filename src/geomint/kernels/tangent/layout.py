"""What steps with directions work with: sizes, what is kept from step to step, scratch.

Directions are columns: of each row of a table there is a number for every direction, in whole lane
values, and 0 where there are fewer directions.
"""

from collections import namedtuple

from ..compiling.recorded import inlined
from ..numbers.blocks import REST, Block, packed, scalar_block, section, sections

# Rows of the problem's state, of the stepper's; conditions; directions, how many of them a step
# carries at once; rows of the stepper's memory, and from which on they are stages in lanes; rows of
# scratch of the problem.
Sizes = namedtuple("Sizes", "n rows m d at_once memory_rows stages scratch")
Given = namedtuple("Given", "n rows m d at_once memory_rows stages scratch pieces")
Kept = namedtuple(
    "Kept",
    "sum carry variance bias begun origin volume state scales condition_scales basis normals",
)
Work = namedtuple("Work", "D X C along S lower upper u v scratch")

GIVEN = Given(1, 1, 1, 1, 1, 1, 1, 1, REST)


@inlined
def lanes_for(count: int) -> int:
    """Return how many numbers make whole lane values of so many."""
    return (count + 7) // 8 * 8


@inlined
def sizes_of(given) -> Sizes:
    """Return the sizes that a sweep is given."""
    n, rows, m, d, at_once, memory_rows, stages, scratch, _ = sections(given, GIVEN)
    return Sizes(
        int(n[0]), int(rows[0]), int(m[0]), int(d[0]), int(at_once[0]), int(memory_rows[0]),
        int(stages[0]), int(scratch[0]),
    )  # fmt: skip


@inlined
def pieces_of(given):
    """Return the numbers of the pieces that rows of the state belong to."""
    return section(given, GIVEN, "pieces")


@inlined
def kept_layout(s: Sizes) -> Kept:
    """Return the layout of what is kept: sums, the state, units, directions, normals."""
    return Kept(
        sum=1,
        carry=1,
        variance=1,
        bias=1,
        begun=1,
        origin=1,
        volume=1,
        state=s.rows,
        scales=s.n,
        condition_scales=s.m,
        basis=s.n * lanes_for(s.d),
        normals=s.n * lanes_for(s.m),
    )


@inlined
def work_layout(s: Sizes) -> Work:
    """Return the layout of scratch: what a step adds to directions, matrices, the density's own."""
    width = lanes_for(s.d)
    size = max(width, lanes_for(s.m))
    return Work(
        D=s.n * width,
        X=s.n * width,
        C=s.n * lanes_for(s.m),
        along=lanes_for(s.m) * width,
        S=size * size,
        lower=size * size,
        upper=size * size,
        u=s.n,
        v=s.n,
        scratch=s.scratch,
    )


def given_block(pieces, sizes: Sizes) -> Block:
    """Return the block of what a sweep is given: sizes, and the problem's pieces."""
    numbers = [float(i) for i, (_, size) in enumerate(pieces) for _ in range(size)]
    return packed(GIVEN._replace(pieces=len(numbers)), pieces=numbers, **sizes._asdict())


def kept_block(sizes: Sizes, **values) -> Block:
    """Return what is kept, as it is at the start: 0 but for the values that are given by name."""
    layout = kept_layout(sizes)
    block = scalar_block(sum(layout))
    for name, numbers in values.items():
        section(block, layout, name).data[:] = numbers
    return block
