"""Command that serves the studio: `rattle studio`."""

from __future__ import annotations

import click

from rattle.cli.command import Command

LOOPBACK = ("127.0.0.1", "localhost", "::1")
OPEN = (
    "warning: the studio will listen on {address}, where other computers can reach it. Everybody who knows its address"
    " with the token can read and write model files in this folder, and what is sent is not encrypted."
)


@click.command(cls=Command)
@click.argument("file", metavar="[FILE]", required=False)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port to listen on.  [default: any free one]")
@click.option("--no-browser", is_flag=True, help="Only print the address, do not open a browser.")
@click.option("--address", default="127.0.0.1", metavar="IP", help="Listen elsewhere than on this computer alone.")
@click.option("--yes", is_flag=True, help="With --address: do not ask.")
def studio(file: str | None, port: int, no_browser: bool, address: str, yes: bool) -> None:
    """See a mechanism, turn its knobs and analyse it, in a browser on this computer.

    FILE is a model file or the name of a shipped example; without it the studio begins with an example.  Edit turns the
    Motion tab into a sheet on which mechanisms are drawn with the mouse; New, or a file with nothing but `format = 1`,
    is an empty one.  Its address
    is printed, and works once; Enter prints a new one.  Only model files in the folder where it was started are read
    and written.  Ctrl-C ends it.

    \b
    Examples: rattle studio
              rattle studio fourbar.toml --no-browser
    """
    if address not in LOOPBACK:
        click.secho(OPEN.format(address=address), fg="yellow", err=True)
        if not yes:
            click.confirm("Listen there?", abort=True, err=True)
    for module in ("uvicorn", "starlette", "websockets"):
        from rattle.results.archive import package

        package(module, "rattle studio")
    from rattle.studio.serve import serve

    serve(file, address, port, not no_browser)
