"""Contact laws of Quoin from Python: ctypes and NumPy, no compiled part.

    import numpy as np, quoin
    law = quoin.load("laws/fracture_energy.so")[0]
    print(law)                                    # properties, states, capabilities
    material = law.material(normal_stiffness=82e9, shear_stiffness=36e9, ...)
    path = material.drive(normal=np.linspace(0, 2e-4, 1000))
    path.plot("tension.png")

Arrays go to the law in place: any float64 array, any stride, is a column without a copy.
"""
import ctypes as c
import os

import numpy as np

ABI_MAJOR, ABI_MINOR = 1, 0
OK, FAILED = 0, 2
ENERGY, TANGENT, PROPERTY_COLUMNS, FLAGS, MIGRATE = 1, 2, 4, 8, 16
DISSIPATED = ("tension", "cohesion", "friction", "crushing")


def _struct(name, *fields):
    return type(name, (c.Structure,), {"_fields_": [(f, t) for f, t in fields]})


_u64, _i64, _u32, _i32, _f64, _str = c.c_uint64, c.c_int64, c.c_uint32, c.c_int32, c.c_double, c.c_char_p
_Column = _struct("quoin_in", ("data", c.c_void_p), ("stride", _i64))  # quoin_out and quoin_out_u32 have the same layout
_Text = _struct("quoin_text", ("struct_size", _u64), ("data", c.c_void_p), ("capacity", _u64), ("length", _u64))
_PropertyColumn = _struct("quoin_property_column", ("id", _str), ("values", _Column))
_PropertyInfo = _struct(
    "quoin_property_info", ("struct_size", _u64), ("id", _str), ("symbol", _str), ("unit", _str), ("description", _str),
    ("kind", _u32), ("flags", _u32), ("default_value", _f64), ("lower", _f64), ("upper", _f64), ("default_from", _str),
    ("default_text", _str), ("choice_count", _u64), ("choices", c.POINTER(_str)))
_StateInfo = _struct(
    "quoin_state_info", ("struct_size", _u64), ("id", _str), ("unit", _str), ("description", _str), ("role", _u32),
    ("kind", _u32), ("flags", _u32), ("reserved", _u32), ("lower", _f64), ("upper", _f64))
_PropertyValue = _struct("quoin_property_value", ("struct_size", _u64), ("id", _str), ("number_count", _u64),
                         ("numbers", c.POINTER(_f64)), ("text", _str))
_Bounds = _struct("quoin_stiffness_bounds", ("struct_size", _u64), ("normal", _f64), ("shear", _f64))
_Batch = _struct(
    "quoin_batch", ("struct_size", _u64), ("count", _u64), ("normal_jump", _Column), ("slip_increment", _Column * 2),
    ("traction_old", _Column * 3), ("state_old", c.POINTER(_Column)), ("traction_new", _Column * 3),
    ("state_new", c.POINTER(_Column)), ("property_column_count", _u64), ("property_columns", c.POINTER(_PropertyColumn)),
    ("energy_stored", _Column), ("dissipated", _Column * 4), ("tangent", _Column * 9), ("flags", _Column),
    ("status", _Column), ("clamped_count", _u64), ("failed_count", _u64), ("worst_status", _u32),
    ("any_yielding", _u32))
_Migration = _struct(
    "quoin_migration", ("struct_size", _u64), ("count", _u64), ("from_law", _str), ("from_schema", _u64),
    ("from_state_count", _u64), ("from_state_ids", c.POINTER(_str)), ("from_states", c.POINTER(_Column)),
    ("normal_jump", _Column), ("traction", _Column * 3), ("energy_stored", _Column), ("normal_shift", _Column),
    ("state_new", c.POINTER(_Column)), ("energy_jump", _Column), ("status", _Column), ("failed_count", _u64))
_create = c.CFUNCTYPE(_i32, c.c_void_p, _u64, c.POINTER(c.POINTER(_PropertyValue)), c.POINTER(c.c_void_p),
                      c.POINTER(_Text))
_Law = _struct(
    "quoin_law", ("struct_size", _u64), ("id", _str), ("name", _str), ("version", _str), ("citation", _str),
    ("description", _str), ("capabilities", _u64), ("convention", c.c_void_p), ("property_count", _u64),
    ("properties", c.POINTER(c.POINTER(_PropertyInfo))), ("state_count", _u64),
    ("states", c.POINTER(c.POINTER(_StateInfo))), ("initial_state_count", _u64), ("initial_states", c.POINTER(_str)),
    ("state_schema", _u64), ("create_material", _create), ("destroy_material", c.CFUNCTYPE(None, c.c_void_p)),
    ("material_number", c.CFUNCTYPE(_i32, c.c_void_p, _str, c.POINTER(_f64))),
    ("initial_state", c.CFUNCTYPE(_i32, c.c_void_p, _str, c.POINTER(_f64))),
    ("stiffness_bounds", c.CFUNCTYPE(_i32, c.c_void_p, c.POINTER(_Bounds))),
    ("evaluate", c.CFUNCTYPE(_i32, c.c_void_p, c.POINTER(_Batch))),
    ("migrate_state", c.CFUNCTYPE(_i32, c.c_void_p, c.POINTER(_Migration), c.POINTER(_Text))))
_HostInfo = _struct("quoin_host_info", ("struct_size", _u64), ("abi_major", _u32), ("abi_minor", _u32), ("name", _str),
                    ("version", _str))
_Library = _struct("quoin_library", ("struct_size", _u64), ("abi_major", _u32), ("abi_minor", _u32), ("name", _str),
                   ("version", _str), ("law_count", _u64), ("laws", c.POINTER(c.POINTER(_Law))),
                   ("extension", c.c_void_p))


class Refused(Exception):
    """The law's own message: every fault, one a line."""


class _Message:
    def __init__(self):
        self.buffer = c.create_string_buffer(16384)
        self.text = _Text(c.sizeof(_Text), c.cast(self.buffer, c.c_void_p), 16384, 0)

    def __str__(self):
        return self.buffer.value.decode("utf-8", "replace")


def _column(array, dtype=np.float64, writable=False):
    """An array (or None) as a column, in place."""
    if array is None:
        return _Column(None, 0)
    if not isinstance(array, np.ndarray) or array.dtype != dtype or array.ndim != 1:
        raise TypeError(f"a column is a one-dimensional array of {np.dtype(dtype).name}")
    if writable and not array.flags.writeable:
        raise TypeError("an output array is read-only")
    stride, rest = divmod(array.strides[0], array.itemsize)
    if rest:
        raise TypeError("the stride of a column is a multiple of its element")
    return _Column(array.ctypes.data, stride)


class Law:
    def __init__(self, library, raw):
        self._library, self._raw = library, raw  # the library stays loaded as long as one of its laws is in use
        for field in ("id", "name", "version", "citation", "description"):
            setattr(self, field, getattr(raw, field).decode())
        self.capabilities = raw.capabilities
        self.state_schema = raw.state_schema
        self.properties = [raw.properties[k].contents for k in range(raw.property_count)]
        self.state_ids = [raw.states[k].contents.id.decode() for k in range(raw.state_count)]
        self.initial_states = [raw.initial_states[k].decode() for k in range(raw.initial_state_count)]

    def __str__(self):
        lines = [f"{self.id} {self.version}: {self.description}"]
        for p in self.properties:
            default = ("required" if p.flags & 1 else f"default {p.default_from.decode()}" if p.default_from else
                       f"default {p.default_text.decode()}" if p.default_text else f"default {p.default_value:g}")
            lines.append(f"  {p.id.decode():30} {p.unit.decode():6} {default:28} {p.description.decode()}")
        lines.append("  states: " + (", ".join(self.state_ids) or "none"))
        return "\n".join(lines)

    def material(self, **properties):
        return Material(self, properties)


class Material:
    """Immutable; freely shared by threads."""

    def __init__(self, law, properties):
        self.law, self._raw = law, law._raw
        self._handle = c.c_void_p()
        values = []
        for name, value in properties.items():
            if isinstance(value, str):
                values.append(_PropertyValue(c.sizeof(_PropertyValue), name.encode(), 0, None, value.encode()))
            else:
                numbers = np.ravel(np.asarray(value, dtype=float))
                data = (_f64 * len(numbers))(*numbers)
                values.append(_PropertyValue(c.sizeof(_PropertyValue), name.encode(), len(numbers), data, None))
        pointers = (c.POINTER(_PropertyValue) * max(1, len(values)))(*[c.pointer(v) for v in values])
        message = _Message()
        status = self._raw.create_material(c.addressof(self._raw), len(values), pointers, c.byref(self._handle),
                                           c.byref(message.text))
        if status != OK:
            raise Refused(f"{law.id}: {message}")
        self.warnings = str(message)

    def __del__(self):
        if getattr(self, "_handle", None):
            self._raw.destroy_material(self._handle)

    def number(self, name):
        value = _f64()
        if self._raw.material_number(self._handle, name.encode(), c.byref(value)) != OK:
            raise KeyError(name)
        return value.value

    def stiffness_bounds(self):
        bounds = _Bounds(c.sizeof(_Bounds))
        if self._raw.stiffness_bounds(self._handle, c.byref(bounds)) != OK:
            raise RuntimeError("stiffness_bounds failed")
        return bounds.normal, bounds.shear

    def initial_state(self, count, name=None):
        """state_count arrays of count values."""
        values = (_f64 * max(1, len(self.law.state_ids)))()
        name = self.law.initial_states[0] if name is None else name
        if self._raw.initial_state(self._handle, name.encode(), values) != OK:
            raise KeyError(name)
        return [np.full(count, values[k]) for k in range(len(self.law.state_ids))]

    def evaluate(self, *arrays, **outputs):
        """One step of N points: see prepare. Returns the batch with its summary."""
        return self.prepare(*arrays, **outputs)()

    def prepare(self, normal_jump, slip, traction, state, *, traction_new=None, state_new=None, energy_stored=None,
                dissipated=None, tangent=None, flags=None, status=None, columns=None):
        """A step of N points that can be taken again and again on the same arrays by calling it: describing them costs
        more than a small batch. Outputs that are not given are not computed; without traction_new and state_new the old
        arrays are overwritten."""
        traction_new = traction if traction_new is None else traction_new
        state_new = state if state_new is None else state_new
        batch = _Batch(struct_size=c.sizeof(_Batch), count=len(normal_jump))
        batch.normal_jump = _column(normal_jump)
        batch.slip_increment = (_Column * 2)(*[_column(a) for a in slip])
        batch.traction_old = (_Column * 3)(*[_column(a) for a in traction])
        batch.traction_new = (_Column * 3)(*[_column(a, writable=True) for a in traction_new])
        old = (_Column * max(1, len(state)))(*[_column(a) for a in state])
        new = (_Column * max(1, len(state)))(*[_column(a, writable=True) for a in state_new])
        batch.state_old, batch.state_new = old, new
        batch.energy_stored = _column(energy_stored, writable=True)
        batch.dissipated = (_Column * 4)(*[_column(a, writable=True) for a in dissipated or [None] * 4])
        batch.tangent = (_Column * 9)(*[_column(a, writable=True) for a in tangent or [None] * 9])
        batch.flags = _column(flags, np.uint32, True)
        batch.status = _column(status, np.uint32, True)
        lists = [normal_jump, *slip, *traction, *traction_new, *state, *state_new, energy_stored, *(dissipated or []),
                 *(tangent or []), flags, status, *(columns or {}).values()]
        if any(a is not None and len(a) != len(normal_jump) for a in lists):
            raise ValueError("columns of different lengths")
        given = [_PropertyColumn(name.encode(), _column(a)) for name, a in (columns or {}).items()]
        property_columns = (_PropertyColumn * max(1, len(given)))(*given)
        batch.property_column_count, batch.property_columns = len(given), property_columns
        return _Step(self, batch, lists)

    def take_over(self, old, normal_jump, traction, state):
        """The state of another material, with every traction kept. Returns this law's state and what is to be added to
        the normal jump from now on."""
        if not self._raw.migrate_state:
            raise Refused(f"{self.law.id}: cannot take over the state of law {old.law.id}")
        count = len(normal_jump)
        state_new, shift = [np.zeros(count) for _ in self.law.state_ids], np.zeros(count)
        migration = _Migration(struct_size=c.sizeof(_Migration), count=count, from_law=old.law.id.encode(),
                               from_schema=old.law.state_schema, from_state_count=len(state))
        migration.from_state_ids = (_str * max(1, len(state)))(*[i.encode() for i in old.law.state_ids])
        migration.from_states = (_Column * max(1, len(state)))(*[_column(a) for a in state])
        migration.normal_jump = _column(normal_jump)
        migration.traction = (_Column * 3)(*[_column(a) for a in traction])
        migration.normal_shift = _column(shift, writable=True)
        migration.state_new = (_Column * max(1, len(state_new)))(*[_column(a, writable=True) for a in state_new])
        message = _Message()
        code = self._raw.migrate_state(self._handle, c.byref(migration), c.byref(message.text))
        if code != OK or migration.failed_count:
            raise Refused(f"{self.law.id}: {migration.failed_count} of {count} points of law {old.law.id} refused: "
                          f"{message}")
        return state_new, shift

    def drive(self, normal=None, s=None, t=None, initial_state=None):
        """One point along total displacements normal, s, t (arrays of equal length, 0 when not given)."""
        n = max(len(a) for a in (normal, s, t) if a is not None)
        d = [np.zeros(n) if a is None else np.asarray(a, dtype=float) for a in (normal, s, t)]
        traction, state = [np.zeros(1) for _ in range(3)], self.initial_state(1, initial_state)
        energy = bool(self.law.capabilities & ENERGY)
        stored = np.zeros(1) if energy else None
        dissipated = [np.zeros(1) for _ in range(4)] if energy else None
        history = np.zeros((n, 3 + len(state) + 1 + 4))
        total = np.zeros(4)
        previous = [0.0, 0.0]
        for i in range(n):
            slip = [np.array([d[k + 1][i] - previous[k]]) for k in range(2)]
            previous = [d[1][i], d[2][i]]
            self.evaluate(d[0][i:i + 1], slip, traction, state, energy_stored=stored, dissipated=dissipated)
            if energy:
                total += [x[0] for x in dissipated]
            history[i] = [x[0] for x in traction] + [x[0] for x in state] + [stored[0] if energy else 0] + list(total)
        return Path(self.law, d, history)


class _Step:
    def __init__(self, material, batch, arrays):
        self._material, self._batch, self._arrays = material, batch, arrays  # the arrays must stay where they are
        self._evaluate, self._handle, self._pointer = material._raw.evaluate, material._handle, c.byref(batch)

    def __call__(self):
        code = self._evaluate(self._handle, self._pointer)
        if code != OK:
            raise RuntimeError(f"{self._material.law.id}: evaluate returns {code}")
        return self._batch


class Path:
    def __init__(self, law, displacement, history):
        k = 3 + len(law.state_ids)
        self.law = law
        self.normal, self.s, self.t = displacement
        self.sigma, self.tau_s, self.tau_t = history[:, 0], history[:, 1], history[:, 2]
        self.state = dict(zip(law.state_ids, history[:, 3:k].T))
        self.stored = history[:, k]
        self.dissipated = dict(zip(DISSIPATED, history[:, k + 1:].T))

    def plot(self, filename):
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
        figure, axes = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
        axes[0].plot(self.normal * 1e3, self.sigma / 1e6)
        axes[0].set(xlabel="opening [mm]", ylabel="normal stress [MPa]", title=self.law.id)
        axes[1].plot(self.s * 1e3, self.tau_s / 1e6)
        axes[1].set(xlabel="sliding [mm]", ylabel="shear stress [MPa]")
        figure.savefig(filename, dpi=120)
        plt.close(figure)


def load(path):
    """The laws of a shared library."""
    library = c.CDLL(os.path.abspath(path))
    entry = library.quoin_library_v1
    entry.restype, entry.argtypes = c.POINTER(_Library), [c.POINTER(_HostInfo), c.POINTER(_Text)]
    host = _HostInfo(c.sizeof(_HostInfo), ABI_MAJOR, ABI_MINOR, b"quoin.py", b"1.0")
    message = _Message()
    info = entry(c.byref(host), c.byref(message.text))
    if not info:
        raise Refused(f"{path}: {message}")
    if info.contents.abi_major != ABI_MAJOR:
        raise Refused(f"{path}: speaks ABI {info.contents.abi_major}, this module {ABI_MAJOR}")
    return [Law(library, info.contents.laws[k].contents) for k in range(info.contents.law_count)]


if __name__ == "__main__":
    import sys
    for file in sys.argv[1:]:
        for found in load(file):
            print(found)
