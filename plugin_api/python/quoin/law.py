"""Contact laws of Quoin from Python: ctypes and NumPy, no compiled part.

    import numpy as np, quoin
    material = quoin.Law("fracture_energy", normal_stiffness=82e9, shear_stiffness=36e9, ...)
    print(material.law)                           # properties, states, capabilities
    path = material.drive(normal=np.linspace(0, 2e-4, 1000))                  # an opening that grows
    path = material.drive(sigma=-0.3e6, s=np.linspace(0, 1e-3, 1000))         # sliding at constant pressure
    path.plot("sliding.png")
    law = quoin.load("laws/fracture_energy.so")[0]                            # of a library, and law.material(...)

The law reads and writes arrays in place: any float64 array with any stride is a column without a copy. Lengths in m,
stresses in Pa, energies in J/m2; opening and tension are positive.
"""
import ctypes as c
import os
import struct
import warnings

import numpy as np

try:
    from .errors import LawRefused as _LawRefused
except ImportError:  # a build with laws only
    _LawRefused = Exception
try:
    from ._quoin import law_path as _try_to_load  # as the command line: in a child process first
except ImportError:
    _try_to_load = None

ABI_MAJOR, ABI_MINOR = 1, 1
OK, CLAMPED, FAILED = 0, 1, 2
ENERGY, TANGENT, PROPERTY_COLUMNS, FLAGS, MIGRATE, DAMAGE = 1, 2, 4, 8, 16, 32
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
    ("any_yielding", _u32), ("damage", _Column * 3))
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


_Batch.__repr__ = lambda b: (f"<batch of {b.count} points: {b.failed_count} failed, {b.clamped_count} clamped, "
                            f"{'yielding' if b.any_yielding else 'elastic'}>")


class Refused(_LawRefused):
    """A library does not load, or the law refuses property values or a law swap. The text is its message: every fault, one
    a line. It is a LawRefused where the host is installed."""


class NotReached(Exception):
    """No displacement near the old one gives the prescribed stress."""


class _Message:
    def __init__(self):
        self.buffer = c.create_string_buffer(16384)
        self.text = _Text(c.sizeof(_Text), c.cast(self.buffer, c.c_void_p), 16384, 0)

    def __str__(self):
        return self.buffer.value.decode("utf-8", "replace")


def _column(name, array, count, dtype=np.float64, writable=False):
    """Returns an array (or None) as a column of count elements, in place. name: for error messages."""
    if array is None:
        return _Column(None, 0)
    if not isinstance(array, np.ndarray) or array.dtype != dtype or array.ndim != 1:
        raise TypeError(f"{name}: a column is a one-dimensional array of {np.dtype(dtype).name}")
    if len(array) != count:
        raise ValueError(f"{name} has {len(array)} values, where the points are {count}")
    if writable and not array.flags.writeable:
        raise TypeError(f"{name}: an output array is read-only")
    stride, rest = divmod(array.strides[0], array.itemsize)
    if rest:
        raise TypeError(f"{name}: the stride of a column is a multiple of its element")
    return _Column(array.ctypes.data, stride)


def _columns(name, arrays, number, count, writable=False):
    """Returns `number` arrays as columns; arrays = None: columns with null data."""
    if arrays is None:
        return (_Column * number)()
    if not isinstance(arrays, (list, tuple, np.ndarray)):
        raise TypeError(f"{name}: {number} arrays in a list are needed, not {type(arrays).__name__}")
    if len(arrays) != number:
        raise ValueError(f"{name}: {len(arrays)} arrays, where {number} are needed")
    columns = [_column(f"{name}[{k}]", a, count, writable=writable) for k, a in enumerate(arrays)]
    return (_Column * max(1, number))(*columns)


class LawInfo:
    """A law of a library: its names, properties and states."""

    def __init__(self, library, raw):
        self._library, self._raw = library, raw  # the reference keeps the library loaded
        for field in ("id", "name", "version", "citation", "description"):
            setattr(self, field, getattr(raw, field).decode())
        self.capabilities = raw.capabilities
        self.state_schema = raw.state_schema
        self.properties = [raw.properties[k].contents for k in range(raw.property_count)]
        self.state_ids = [raw.states[k].contents.id.decode() for k in range(raw.state_count)]
        self.initial_states = [raw.initial_states[k].decode() for k in range(raw.initial_state_count)]

    def __repr__(self):
        return f"<law {self.id} {self.version}: {len(self.properties)} properties, {len(self.state_ids)} states>"

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
    """A law with property values. Immutable, so threads may share it."""

    def __init__(self, law, properties):
        self.law, self._raw, self._given = law, law._raw, properties
        self._handle = c.c_void_p()
        values = []
        for name, value in properties.items():
            if isinstance(value, str):
                values.append(_PropertyValue(c.sizeof(_PropertyValue), name.encode(), 0, None, value.encode()))
            else:
                try:
                    numbers = np.ravel(np.asarray(value, dtype=float))
                except (TypeError, ValueError):
                    raise TypeError(f"{name}: a number, an array of numbers or a word is needed, not {value!r}") from None
                data = (_f64 * len(numbers))(*numbers)
                values.append(_PropertyValue(c.sizeof(_PropertyValue), name.encode(), len(numbers), data, None))
        pointers = (c.POINTER(_PropertyValue) * max(1, len(values)))(*[c.pointer(v) for v in values])
        message = _Message()
        status = self._raw.create_material(c.addressof(self._raw), len(values), pointers, c.byref(self._handle),
                                           c.byref(message.text))
        if status != OK:
            raise Refused(f"{law.id}: {message}")
        self.warnings = str(message)

    def __repr__(self):
        return f"{self.law.id}({', '.join(f'{name}={value!r}' for name, value in self._given.items())})"

    def __del__(self):
        if getattr(self, "_handle", None):
            self._raw.destroy_material(self._handle)

    def __copy__(self):
        return self  # it never changes, and the handle has one owner

    def __deepcopy__(self, memo):
        return self

    def number(self, name):
        value = _f64()
        if self._raw.material_number(self._handle, name.encode(), c.byref(value)) != OK:
            raise KeyError(f"law {self.law.id} has no number {name!r}")
        return value.value

    def stiffness_bounds(self):
        bounds = _Bounds(c.sizeof(_Bounds))
        if self._raw.stiffness_bounds(self._handle, c.byref(bounds)) != OK:
            raise RuntimeError("stiffness_bounds failed")
        return bounds.normal, bounds.shear

    def initial_state(self, count, name=None):
        """Returns the initial states: state_count arrays of count values."""
        values = (_f64 * max(1, len(self.law.state_ids)))()
        name = self.law.initial_states[0] if name is None else name
        if self._raw.initial_state(self._handle, name.encode(), values) != OK:
            raise KeyError(f"law {self.law.id} has no initial state {name!r}, but {', '.join(self.law.initial_states)}")
        return [np.full(count, values[k]) for k in range(len(self.law.state_ids))]

    def evaluate(self, *arrays, **outputs):
        """Computes one step of N points, with the arguments of prepare. Returns the batch with its summary."""
        return self.prepare(*arrays, **outputs)()

    def prepare(self, normal_jump, slip, traction, state, *, traction_new=None, state_new=None, energy_stored=None,
                dissipated=None, tangent=None, flags=None, status=None, columns=None, damage=None):
        """Returns a callable that computes a step of N points on the same arrays at every call. Preparation costs more than
        the step of a small batch. Outputs that are not given are not computed. Without traction_new and state_new the old
        arrays are overwritten. A point whose inputs are not finite keeps its stress and state. The batch that each call
        returns has the number of such points in failed_count; the array status has their status."""
        traction_new = traction if traction_new is None else traction_new
        state_new = state if state_new is None else state_new
        if not isinstance(normal_jump, np.ndarray) or normal_jump.ndim != 1:
            raise TypeError("normal_jump: a column is a one-dimensional array of float64")
        count, states = len(normal_jump), len(self.law.state_ids)
        batch = _Batch(struct_size=c.sizeof(_Batch), count=count)
        batch.normal_jump = _column("normal_jump", normal_jump, count)
        batch.slip_increment = _columns("slip", slip, 2, count)
        batch.traction_old = _columns("traction", traction, 3, count)
        batch.traction_new = _columns("traction_new", traction_new, 3, count, writable=True)
        old = _columns("state", state, states, count)
        new = _columns("state_new", state_new, states, count, writable=True)
        batch.state_old, batch.state_new = old, new
        batch.energy_stored = _column("energy_stored", energy_stored, count, writable=True)
        batch.dissipated = _columns("dissipated", dissipated, 4, count, writable=True)
        batch.tangent = _columns("tangent", tangent, 9, count, writable=True)
        batch.flags = _column("flags", flags, count, np.uint32, True)
        batch.status = _column("status", status, count, np.uint32, True)
        batch.damage = _columns("damage", damage, 3, count, writable=True)
        given = [_PropertyColumn(name.encode(), _column(name, a, count)) for name, a in (columns or {}).items()]
        property_columns = (_PropertyColumn * max(1, len(given)))(*given)
        batch.property_column_count, batch.property_columns = len(given), property_columns
        arrays = [normal_jump, *slip, *traction, *traction_new, *state, *state_new, energy_stored, dissipated, tangent,
                  flags, status, columns, damage]
        return _Step(self, batch, arrays)

    def take_over(self, old, normal_jump, traction, state):
        """Converts the state of another material at constant traction. Returns the states of this law and the shift of the
        normal jump, m, for all later steps. Warns of points whose damage this law cannot have, and that lose it."""
        if not self._raw.migrate_state:
            raise Refused(f"{self.law.id}: cannot take over the state of law {old.law.id}")
        count = len(normal_jump)
        state_new, shift = [np.zeros(count) for _ in self.law.state_ids], np.zeros(count)
        status = np.zeros(count, np.uint32)
        migration = _Migration(struct_size=c.sizeof(_Migration), count=count, from_law=old.law.id.encode(),
                               from_schema=old.law.state_schema, from_state_count=len(state))
        migration.from_states = _columns("state", state, len(old.law.state_ids), count)
        migration.from_state_ids = (_str * max(1, len(state)))(*[i.encode() for i in old.law.state_ids])
        migration.normal_jump = _column("normal_jump", normal_jump, count)
        migration.traction = _columns("traction", traction, 3, count)
        migration.normal_shift = _column("normal_shift", shift, count, writable=True)
        migration.state_new = _columns("state_new", state_new, len(state_new), count, writable=True)
        migration.status = _column("status", status, count, np.uint32, True)
        message = _Message()
        code = self._raw.migrate_state(self._handle, c.byref(migration), c.byref(message.text))
        if code != OK or migration.failed_count:
            raise Refused(f"{self.law.id}: {migration.failed_count} of {count} points of law {old.law.id} refused: "
                          f"{message}")
        if limited := int(np.count_nonzero(status == CLAMPED)):
            warnings.warn(f"{self.law.id}: {limited} of {count} points lose damage that they have in {old.law.id}")
        return state_new, shift

    def drive(self, normal=None, s=None, t=None, initial_state=None, *, sigma=None, tau_s=None, tau_t=None):
        """Computes one point along a path. Along each of n, s, t either the total displacement is prescribed (normal, s, t;
        m; 0 when not given) or the stress (sigma, tau_s, tau_t; Pa). Values are arrays of equal length or constant numbers.

        A displacement under a prescribed stress is accurate to 1e-10 of the stress, or to the last digit of the
        displacement. It is found by Newton's method with the law's tangent, then by bisection, on the rising branch from
        the old point. NotReached has the step at which the joint cannot carry the stress, because it has softened, slips
        or is crushed: prescribe the displacement there. ValueError has the parameter with a wrong length or a value that
        is not finite. ArithmeticError has the step at which the law reports the point as failed."""
        targets, controlled = _targets([("normal", normal, "sigma", sigma), ("s", s, "tau_s", tau_s),
                                        ("t", t, "tau_t", tau_t)])
        point = _Point(self, initial_state)
        follow = point.follow_stresses if controlled else point.follow
        return Path(self.law, *follow(targets, controlled))


def _targets(axes):
    """Returns the prescribed values of the axes as columns of one table, and the indices of axes with prescribed stress."""
    chosen, controlled = [], []
    for k, (name, displacement, stress_name, stress) in enumerate(axes):
        if displacement is not None and stress is not None:
            raise ValueError(f"{name} and {stress_name}: along one axis prescribe one of the two")
        if stress is not None:
            controlled.append(k)
            name, displacement = stress_name, stress
        if displacement is not None:
            values = np.asarray(displacement, dtype=float)
            if values.ndim > 1 or values.size == 0:
                raise ValueError(f"{name}: a number or a one-dimensional array, not of shape {values.shape}")
            for i in np.flatnonzero(~np.isfinite(values))[:1]:
                raise ValueError(f"{name}[{i}] is {values.flat[i]}: every value must be finite")
            chosen.append((k, name, values))
    if not chosen:
        raise ValueError("nothing is prescribed: give " + ", ".join(f"{a[0]} or {a[2]}" for a in axes))
    _, longest, values = max(chosen, key=lambda c: c[2].size)
    table = np.zeros((values.size, 3))
    for k, name, column in chosen:
        if column.ndim and column.size != len(table):
            raise ValueError(f"{name} has {column.size} values, where {longest} has {len(table)}")
        table[:, k] = column
    return table, controlled


class _Point:
    """One point of a material, in fixed arrays, so that its steps are prepared once."""

    # Relative tolerance of a prescribed stress.
    TOLERANCE = 1e-10

    def __init__(self, material, initial_state):
        self.material, states = material, len(material.law.state_ids)
        self.move = np.zeros(3)  # d_n at the end of a step, sliding along s and t over it
        self.old, self.new = np.zeros((2, 3 + states))  # stresses and states
        self.energy = np.zeros(5)  # stored, and dissipated by mode during the step
        self.old[3:] = np.ravel(material.initial_state(1, initial_state))
        self.with_energy = bool(material.law.capabilities & ENERGY)

    def _step(self, old, new, **outputs):
        """Prepares a step from the record old to the record new; a record is stresses and states."""
        cells = [[record[k:k + 1] for k in range(len(record))] for record in (self.move, old, new, self.energy)]
        move, before, after, energy = cells
        if self.with_energy:
            outputs.update(energy_stored=energy[0], dissipated=energy[1:])
        return self.material.prepare(move[0], move[1:], before[:3], before[3:], traction_new=after[:3],
                                     state_new=after[3:], **outputs)

    def _fail(self, i):
        opening, *sliding = self.move.tolist()
        raise ArithmeticError(f"{self.material.law.id}: the point fails in step {i}, at normal = {opening} m and a "
                              f"sliding of {sliding[0]} and {sliding[1]} m")

    def follow(self, displacement, _):
        """Computes a path of prescribed displacements. Returns displacements, and the record and energies of every step."""
        step, moves = self._step(self.old, self.old), displacement.copy()
        moves[:, 1:] = np.diff(displacement[:, 1:], axis=0, prepend=0.0)
        records, energies = np.zeros((len(moves), len(self.old))), np.zeros((len(moves), 5))
        for i in range(len(moves)):
            self.move[:] = moves[i]
            if step().failed_count:
                self._fail(i)
            records[i], energies[i] = self.old, self.energy
        return displacement, records, energies

    def follow_stresses(self, targets, controlled):
        """Computes a path on which the axes in `controlled` have prescribed stresses; returns what follow returns."""
        tangent = np.full(9, np.nan)
        can = self.material.law.capabilities & TANGENT
        trial = self._step(self.old, self.new, tangent=[tangent[k:k + 1] for k in range(9)] if can else None)
        normal, shear = self.material.stiffness_bounds()
        stiffness = (normal, shear, shear)
        displacement = targets.copy()
        displacement[:, controlled] = 0.0
        records, energies = np.zeros((len(targets), len(self.old))), np.zeros((len(targets), 5))
        before = np.zeros(3)
        for i, target in enumerate(targets):
            # Total opening, and slip since the last step. Unknown ones start from no change.
            self.move[:] = displacement[i] - before
            self.move[0] = before[0] if 0 in controlled else displacement[i, 0]
            self.move[[k for k in controlled if k]] = 0.0
            allowed = [self.TOLERANCE * (max(abs(target[k]), abs(self.old[k])) or 1.0) for k in range(3)]

            def excess(k, move):
                """Returns the excess of the stress along k over its target, and its slope or nan."""
                self.move[k] = move
                if trial().failed_count:
                    self._fail(i)
                return self.new[k] - target[k], tangent[4 * k]

            def none_left(k):
                last_digits = 4 * stiffness[k] * np.spacing(abs(self.move[k]))
                return abs(self.new[k] - target[k]) <= max(allowed[k], min(last_digits, 1e4 * allowed[k]))

            # Axis by axis: the coupling is weak, and each round corrects the errors of the last one.
            for _ in range(100):
                for k in controlled:
                    if not _solve(lambda move: excess(k, move), lambda: none_left(k), self.move[k], stiffness[k]):
                        self._not_reached(i, k, target)
                if all(none_left(k) for k in controlled):
                    break
            else:
                self._not_reached(i, controlled[0], target)
            for k in controlled:
                displacement[i, k] = self.move[k] + (before[k] if k else 0.0)
            before = displacement[i]
            self.old[:] = self.new
            records[i], energies[i] = self.new, self.energy
        return displacement, records, energies

    def _not_reached(self, i, k, target):
        name, old = ("sigma", "tau_s", "tau_t")[k], ", ".join(f"{x:.6g}" for x in self.old[:3])
        raise NotReached(f"{self.material.law.id}: no displacement near the old one gives {name}[{i}] = "
                         f"{target[k]:.6g} Pa (from sigma, tau_s, tau_t = {old} Pa): the joint cannot carry it; "
                         "prescribe the displacement there")


def _solve(excess, done, start, stiffness):
    """Searches a displacement at which excess(displacement), a stress with its slope, is within the tolerance. Returns False
    if there is none. Slopes do not exceed the stiffness, so that a step with the stiffness does not overshoot."""
    x = start
    over, slope = excess(start)
    first = over
    for _ in range(20):
        if done():
            return True
        # A falling branch takes a step with the stiffness, towards the rising branch: a prescribed stress cannot follow it.
        after = x - over / (slope if slope > 1e-12 * stiffness else stiffness)
        if after == x or not np.isfinite(after):
            break
        x = after
        over, slope = excess(x)

    # Growing steps from the start until the excess is within the tolerance or changes sign, then bisection.
    near, reach = start, abs(first) / stiffness
    for _ in range(40):
        far = near - np.copysign(reach, first)
        over, _ = excess(far)
        if done():
            return True
        if (over > 0) != (first > 0):
            break
        near, reach = far, 1.6 * reach
    else:
        return False
    while True:
        middle = 0.5 * (near + far)
        over, _ = excess(middle)
        if done():
            return True
        if middle in (near, far):  # the stress is discontinuous there
            return False
        near, far = (middle, far) if (over > 0) == (first > 0) else (near, middle)


class Law(Material):
    """A law by its name or by the path of its library, with its properties: Law("elastic", normal_stiffness=1e9, ...).
    The search path is the folders of $QUOIN_LAW_PATH and those beside this package."""

    def __init__(self, name, /, **properties):
        if not isinstance(name, str):
            raise TypeError(f"name: of a law, or the path of a library, not {type(name).__name__}")
        super().__init__(find(name), properties)

    def evaluate(self, normal_jump, slip, traction, state, **outputs):
        """Computes one step of N points, arrays in place. As prepare, but raises ValueError if a value is not finite.

            normal_jump: (N,) total opening at the end of the step, m; slip: two arrays (N,), slip during the step, m;
            traction: three arrays (N,), sigma, tau_s, tau_t, Pa; state: the arrays of initial_state(N)."""
        step = self.prepare(normal_jump, slip, traction, state, **outputs)
        for name, arrays in (("normal_jump", [normal_jump]), ("slip", slip), ("traction", traction), ("state", state)):
            for k, array in enumerate(arrays):
                for i in np.flatnonzero(~np.isfinite(array))[:1]:
                    which = name if name == "normal_jump" else f"{name}[{k}]"
                    raise ValueError(f"{which}[{i}] is {array[i]}: every value must be finite")
        return step()


class _Step:
    def __init__(self, material, batch, arrays):
        self._material, self._batch, self._arrays = material, batch, arrays  # references keep the arrays in memory
        self._evaluate, self._handle, self._pointer = material._raw.evaluate, material._handle, c.byref(batch)

    def __call__(self):
        code = self._evaluate(self._handle, self._pointer)
        if code != OK:
            raise RuntimeError(f"{self._material.law.id}: evaluate returns {code}")
        return self._batch


class Path:
    """Displacements, stresses, states and energies after every step: arrays of one length."""

    def __init__(self, law, displacement, records, energies):
        self.law = law
        self.normal, self.s, self.t = displacement.T
        self.sigma, self.tau_s, self.tau_t = records[:, :3].T
        self.state = dict(zip(law.state_ids, records[:, 3:].T))
        self.stored = energies[:, 0]
        self.dissipated = dict(zip(DISSIPATED, np.cumsum(energies[:, 1:], axis=0).T))  # since the start, by mode

    def __len__(self):
        return len(self.normal)

    def __repr__(self):
        ranges = ", ".join(f"{name} {values.min():.6g} to {values.max():.6g} {unit}" for name, values, unit in (
            ("normal", self.normal, "m"), ("sigma", self.sigma, "Pa"), ("s", self.s, "m"), ("tau_s", self.tau_s, "Pa")))
        return f"<path of {len(self)} steps under law {self.law.id}: {ranges}>"

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


def _missing_of(data):
    """Returns what is missing of the bytes of a shared library, "" if it is whole. The loader maps one that was cut off, and
    its use ends the process."""
    if not data:
        return "the file is empty"
    if data[:6] != b"\x7fELF\x02\x01":  # not of 64 bits, little-endian: left to the loader
        return ""
    ends = [64]  # of the head; then of the tables and of the parts that are mapped
    if len(data) >= ends[0]:
        parts_at, sections_at = struct.unpack_from("<QQ", data, 32)
        part_size, parts, section_size, sections = struct.unpack_from("<4H", data, 54)
        if parts and part_size != 56:
            return "its head is damaged"
        ends += [parts_at + parts * part_size, sections_at + sections * section_size]
        if max(ends) <= len(data):
            heads = [struct.unpack_from("<4Q", data, parts_at + k * part_size + 8) for k in range(parts)]
            ends += [offset + length for offset, _, _, length in heads]
    return "" if max(ends) <= len(data) else (f"the file has {len(data)} bytes of {max(ends)}: it was not copied or built "
                                              "to its end")


_loaded = {}  # libraries by path and bytes; ctypes unloads none


def _library(path, failed):
    """Returns a library with the code that its file has now. It runs from a copy, so that the file may be overwritten."""
    try:
        with open(path, "rb") as file:
            data = file.read()
    except (OSError, ValueError) as fault:
        raise Refused(f"{failed}{getattr(fault, 'strerror', None) or fault}; check the path, or build the law") from None
    key = path, len(data), hash(data)
    if key in _loaded:
        return _loaded[key]
    if missing := _missing_of(data):
        raise Refused(f"{failed}it is not whole: {missing}; copy or build it again")
    if _try_to_load:
        try:
            _try_to_load(path)
        except _LawRefused as refused:
            raise Refused(str(refused)) from None
    if "QUOIN_LAW_IN_PLACE" not in os.environ:
        try:
            # It stays open: the loader identifies libraries by their names too, so that the name must stay in use.
            copy = os.memfd_create("law")
        except (AttributeError, OSError):  # a system without files in memory
            copy = None
        if copy is not None:
            try:
                with open(copy, "wb", closefd=False) as file:
                    file.write(data)
                _loaded[key] = c.CDLL(f"/proc/self/fd/{copy}")
                return _loaded[key]
            except OSError:
                os.close(copy)
    # A law may need files beside it, and a system may refuse to run code from memory.
    try:
        _loaded[key] = c.CDLL(path)
    except OSError as fault:
        raise Refused(f"{failed}the dynamic loader says: {str(fault).removeprefix(path + ': ')}; give a shared library built "
                      "for this machine") from None
    return _loaded[key]


def load(path):
    """Returns the laws of a shared library, with the code that its file has now."""
    path = os.path.abspath(os.fsdecode(path))
    failed = f"law library {path} could not be loaded: "
    library = _library(path, failed)
    try:
        entry = library.quoin_library_v1
    except AttributeError:
        raise Refused(f"{failed}it exports no quoin_library_v1, so it is no contact law of ABI version {ABI_MAJOR}") from None
    entry.restype, entry.argtypes = c.POINTER(_Library), [c.POINTER(_HostInfo), c.POINTER(_Text)]
    host = _HostInfo(c.sizeof(_HostInfo), ABI_MAJOR, ABI_MINOR, b"quoin.law", b"1.0")
    message = _Message()
    info = entry(c.byref(host), c.byref(message.text))
    if not info:
        raise Refused(f"{path}: {message}")
    if info.contents.abi_major != ABI_MAJOR:
        raise Refused(f"{path}: speaks ABI {info.contents.abi_major}, this module {ABI_MAJOR}")
    return [LawInfo(library, info.contents.laws[k].contents) for k in range(info.contents.law_count)]


def folders():
    """Returns the folders of the search path of laws."""
    here = os.path.dirname(os.path.abspath(__file__))
    found = [f for f in os.environ.get("QUOIN_LAW_PATH", "").split(":") if f]
    try:
        with open(os.path.join(here, "where.txt"), encoding="utf-8") as file:  # written by the installation
            found.append(os.path.normpath(os.path.join(here, file.read().strip())))
    except FileNotFoundError:
        pass
    return found


def find(name):
    """Returns the law of this name in the search path, or the first one of the library at this path."""
    if "/" in name:
        return load(name)[0]
    tried = [os.path.join(folder, name + ".so") for folder in folders()]
    for path in tried:
        if os.path.exists(path):
            return next((law for law in load(path) if law.id == name), None) or load(path)[0]
    raise Refused(f"law '{name}' could not be loaded: not found; tried {', '.join(tried) or 'no folder'}; set "
                  "QUOIN_LAW_PATH or give the path of its library")


if __name__ == "__main__":
    import sys
    for file in sys.argv[1:]:
        for found in load(file):
            print(found)
