"""Scenes: loaded from TOML files, built in code, written. Objects have the names of the TOML keys. host/scenes/README.md
and host/scenes/BLOCKS.md describe the keys. The reader of scene files checks these objects too."""
import copy
import os

import numpy as np

from . import _quoin

# Keys that are lists of tables. An append creates the list.
LISTS = ("block", "dry_wall", "arch", "joint_rule", "tie", "spring", "strip", "floor", "beam", "dowel", "fill", "mass", "monitor", "damage", "stage")
TABLES = ("materials", "joints", "solver", "output", "contact")


class Table:
    """Keys as attributes and as items: table.cohesion is table["cohesion"]. A key with the value None is left out."""

    def __init__(self, *args, **keys):
        object.__setattr__(self, "_keys", {})
        for key, value in dict(*args, **keys).items():
            self[key] = value

    def __getitem__(self, key):
        return self._keys[key]

    def __setitem__(self, key, value):
        if not isinstance(key, str):
            raise TypeError(f"a key is a name, not {key!r}")
        self._keys[key] = wrapped(value)

    def __delitem__(self, key):
        del self._keys[key]

    def __getattr__(self, key):
        if key.startswith("__") or "_keys" not in self.__dict__:  # during a copy
            raise AttributeError(key)
        try:
            return self._keys[key]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no key {key!r}; it has {', '.join(self._keys) or 'none'}"
                                 ) from None

    def __setattr__(self, key, value):
        self[key] = value

    def __delattr__(self, key):
        if key not in self._keys:
            raise AttributeError(key)
        del self[key]

    def __contains__(self, key):
        return key in self._keys

    def __iter__(self):
        return iter(self._keys)

    def __len__(self):
        return len(self._keys)

    def keys(self):
        return self._keys.keys()

    def items(self):
        return self._keys.items()

    def __dir__(self):
        return [*super().__dir__(), *self._keys]

    def __eq__(self, other):
        return isinstance(other, Table) and plain(self) == plain(other)

    __hash__ = None

    def __repr__(self):
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self._keys.items())})"

    def __copy__(self):
        return type(self)(self._keys)

    def __deepcopy__(self, memo):
        fresh = type(self)()
        for key, value in self._keys.items():
            fresh._keys[key] = copy.deepcopy(value, memo)
        return fresh


class Block(Table):
    """[[block]]: one convex block, by box, vertices (with or without faces) or mesh."""


class DryWall(Table):
    """[[dry_wall]]: a wall of separate blocks of any motion."""


class Arch(Table):
    """[[arch]]"""


class Tie(Table):
    """[[tie]]: a bar between points of two blocks."""


class Spring(Table):
    """[[spring]]: springs and dashpots between a face and the ground."""


class Strip(Table):
    """[[strip]]: fibres along a line on faces, bonded by a law."""


class Floor(Table):
    """[[floor]]: a membrane between walls, with connectors to them."""


class Beam(Table):
    """[[beam]]: a bar that bends, or a cable, supported by blocks."""


class Dowel(Table):
    """[[dowel]]: a bar across a joint, elastic and then plastic in its axis and in shear."""


class Fill(Table):
    """[[fill]]: soil on faces, with its weight and its pressure between active and passive."""


class Mass(Table):
    """[[mass]]: a point mass on a block."""


class Monitor(Table):
    """[[monitor]]: a block or point whose motion is in monitors.csv."""


class JointRule(Table):
    """[[joint_rule]]"""


class Damage(Table):
    """[[damage]]: damage of joints before the first stage."""


class Wall(Table):
    """[wall]: a wall of the lattice."""


class Joint(Table):
    """[joints.NAME]: a law and its properties."""


class BlockMaterial(Table):
    """[materials.NAME]"""


class Stage(Table):
    """[[stage]]"""


def wrapped(value):
    if isinstance(value, dict):
        return Table(value)
    if isinstance(value, (list, tuple)):
        return [wrapped(v) for v in value]
    return value


def plain(value, key="scene"):
    """The value as dictionaries, lists, numbers and texts. TypeError, with the dotted key, for values that a scene cannot
    hold."""
    if isinstance(value, (bool, int, float, str)) and not isinstance(value, np.generic):
        return value
    if isinstance(value, (Table, dict)):
        return {k: plain(v, f"{key}.{k}" if key != "scene" else k) for k, v in value.items() if v is not None}
    if isinstance(value, (list, tuple)):
        return [plain(v, f"{key}.{i + 1}") for i, v in enumerate(value)]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist(), key)
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise TypeError(f"{key}: a value of type {type(value).__name__}; allowed: a number, a word, true or false, an array, "
                    "a list or a table")


class Scene(Table):
    """A scene: materials, joints, a wall, building, blocks, and stages. Scene.load reads one; scene.wall.courses,
    scene.joints.mortar.cohesion, scene.stage[0].pressure are its values; scene.check() raises its faults."""

    def __init__(self, *args, **keys):
        object.__setattr__(self, "_file", None)     # file that it was loaded from
        object.__setattr__(self, "_loaded", None)   # contents of the file, as a document
        object.__setattr__(self, "_text", None)     # contents of the file, as text
        object.__setattr__(self, "_hashes", {})     # hashes of the files that it names
        super().__init__(*args, **keys)

    @classmethod
    def load(cls, path):
        """Loads a scene file. BadInput, with file and line, for invalid TOML; check and simulations check the values."""
        path = os.fspath(path)
        document, text = _quoin.parse(path)
        scene = cls(document)
        object.__setattr__(scene, "_file", os.path.abspath(path))
        object.__setattr__(scene, "_loaded", scene._document())
        object.__setattr__(scene, "_text", text)
        object.__setattr__(scene, "_hashes", _quoin.check(*scene._source()))
        return scene

    def __getattr__(self, key):
        if key not in self.__dict__.get("_keys", {}) and key in LISTS + TABLES:
            self[key] = [] if key in LISTS else Table()
        return super().__getattr__(key)

    def _document(self):
        return {k: v for k, v in plain(self).items() if not (k in LISTS + TABLES and not v)}

    def _place(self):
        """Name in messages, whose folder is the base of the paths in the scene."""
        return self._file or "scene"

    def _source(self):
        """Input of the reader. An unchanged file is its text, so that messages have its lines."""
        document = self._document()
        return self._text if self._file and document == self._loaded else document, self._place(), self._hashes

    def check(self):
        """Raises BadInput with all faults of keys and values, or LawRefused. Faults of shapes are found when a
        Simulation is made of it."""
        _quoin.check(*self._source())

    def text(self):
        """The scene as TOML."""
        return _quoin.text(self._document())

    def write(self, path):
        """Writes a TOML file that loads as the same scene. Relative paths of other files are adapted."""
        path = os.path.abspath(os.fspath(path))
        text = _quoin.text(self._with_files_from(os.path.dirname(path)))
        with open(path + ".part", "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(path + ".part", path)

    def _with_files_from(self, folder):
        """The document, with paths of files relative to that folder; None: absolute paths."""
        here = os.path.dirname(self._file) if self._file else os.getcwd()
        document = copy.deepcopy(self._document())

        def moved(table, key):
            if isinstance(table, dict) and isinstance(table.get(key), str):
                file = os.path.join(here, table[key])
                table[key] = os.path.abspath(file) if folder is None or os.path.isabs(table[key]) else \
                    os.path.relpath(file, folder)
        moved(document, "start")
        for block in document.get("block", []):
            moved(block, "mesh")
        for stage in document.get("stage", []):
            ground = stage.get("ground_motion") if isinstance(stage, dict) else None
            supports = ground.get("support", []) if isinstance(ground, dict) else []
            for motion in [ground, *(supports if isinstance(supports, list) else [])]:
                moved(motion, "file")
                if isinstance(motion, dict) and "file" not in motion:
                    for axis in "xyz":
                        moved(motion, axis)
        return document

    def __eq__(self, other):
        return isinstance(other, Scene) and self._with_files_from(None) == other._with_files_from(None)

    __hash__ = None

    def copy(self):
        return copy.deepcopy(self)

    def __deepcopy__(self, memo):
        fresh = super().__deepcopy__(memo)
        for of_file in ("_file", "_loaded", "_text", "_hashes"):
            object.__setattr__(fresh, of_file, getattr(self, of_file))
        return fresh

    def __repr__(self):
        return f"<scene {self._keys.get('title') or self._place()!r}: {', '.join(self._keys)}>"


def scene_of(scene):
    """A scene, or that of a file."""
    if isinstance(scene, Scene):
        return scene
    if isinstance(scene, (str, os.PathLike)):
        return Scene.load(scene)
    raise TypeError(f"scene: a quoin.Scene or the path of a scene file is needed, not {type(scene).__name__}")
