"""Quoin from Python: laws on arrays, scenes, and simulations that are stepped from outside.

    import quoin
    scene = quoin.Scene.load("host/scenes/solid_wall_030.toml")
    run = quoin.run(scene)
    run.history["horizontal_force_N"].max()

host/python/README.md describes all of it. A build without the host, or without pybind11, has only laws.
"""
from .law import Law, LawInfo, Material, NotReached, Path, Refused, find, load  # noqa: F401

try:
    from .errors import BadInput, Error, Gone, LawRefused, NumericalFailure  # noqa: F401
except ModuleNotFoundError:  # a build with laws only
    pass
else:
    try:
        from ._quoin import version as __version__
    except ModuleNotFoundError as missing:
        if missing.name != "quoin._quoin":
            raise
    else:
        from ._quoin import add_law_folder
        from .law import folders
        for _folder in folders():
            add_law_folder(_folder)
        from . import shapes  # noqa: F401
        from .analysis import Limit, Modes, limit, modes, properties_of  # noqa: F401
        from .meshes import read_blocks  # noqa: F401
        from .results import Moment, Results, unit  # noqa: F401
        from .results import open_results as open  # noqa: F401
        from .run import Frame, Run, run  # noqa: F401
        from .scene import (Arch, Beam, Block, BlockMaterial, Damage, Dowel, DryWall, Fill, Floor, Joint,  # noqa: F401
                            JointRule, Mass, Monitor, Scene, Spring, Stage, Strip, Table, Tie, Wall)
        from .simulation import Simulation  # noqa: F401
        from .spectrum import ResponseSpectrum, response_spectrum  # noqa: F401


def __getattr__(name):
    if name in ("Scene", "Simulation", "run", "limit", "modes", "open", "response_spectrum"):
        raise AttributeError(f"quoin.{name}: this installation has the laws alone; build the host with pybind11-dev and "
                             "python3-dev installed (cmake says why it left it out)")
    raise AttributeError(f"module 'quoin' has no attribute {name!r}")
