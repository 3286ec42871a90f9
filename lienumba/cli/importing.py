"""The command that makes a scenario of a robot in another format."""

from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Literal

import typer

from lienumba.present.terminal import console


def import_(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A robot: URDF or MJCF.", show_default=False)],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="SCENARIO", help="The scenario to write (default: to the terminal)."),
    ] = None,
    base: Annotated[
        Literal["fixed", "free"] | None,
        typer.Option(help="Weld the root to the ground, or let it float (default: as the file has it)."),
    ] = None,
    keep_limits: Annotated[bool, typer.Option("--keep-limits", help="Make stops of the limits of joints.")] = False,
    qpos: Annotated[
        str | None, typer.Option(metavar="NUMBERS", help='Where it starts, as MuJoCo orders it: "0 0.5 -1".')
    ] = None,
    keyframe: Annotated[str | None, typer.Option(metavar="NAME", help="The keyframe at which it starts.")] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse what has no counterpart or is unknown.")] = False,
    density: Annotated[
        float | None,
        typer.Option(metavar="KG/M3", help="Links of URDF without mass get that of their collision shapes."),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing scenario.")] = False,
) -> None:
    """Make a scenario of a robot in URDF or MJCF (needs the extra `import`)."""
    with console.exit_codes():
        from lienumba.importing import from_file
        from lienumba.scenario.base.arguments import parse_numbers
        from lienumba.store.targets import claimed

        with ExitStack() as stack:
            if output is not None:
                own = stack.enter_context(claimed(output, "scenario", (".toml",), overwrite))
            system = from_file(
                file, base=base, qpos=None if qpos is None else parse_numbers(qpos, "--qpos "), keyframe=keyframe,
                keep_limits=keep_limits, strict=strict, density=density,
            )  # fmt: skip
            if output is not None:
                system.write(own)
        with console.unheard():
            console.say(system.summary(), err=output is None)
            console.say(system.to_toml() if output is None else f"wrote {output}; try: lienumba validate {output}")
