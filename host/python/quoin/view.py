"""Arrays of a simulation without copies."""
import numbers
import weakref

import numpy as np

from .errors import Gone

READING = ("__call__", "reduce", "accumulate", "reduceat", "outer")  # methods of a ufunc that write to `out` alone


class View(np.lib.mixins.NDArrayOperatorsMixin):
    """An array of a simulation, read in place: view.max(), view[3:5], np.sum(view), 2 * view copy nothing but their
    results; np.array(view) is a copy. After a step it has the new values. When the simulation is closed or deleted it
    raises quoin.Gone. Velocities can be written, view[...] = values."""

    def __init__(self, simulation, what, fetch, writeable=False):
        self._simulation, self._what, self._fetch = weakref.ref(simulation), what, fetch
        self._writeable = writeable

    def _array(self):
        simulation = self._simulation()
        if simulation is None:
            raise Gone(f"{self._what}: its simulation is gone")
        return self._fetch(simulation._session_of(self._what))

    @staticmethod
    def _own(result, array):
        """A result without reference to the simulation's memory."""
        if isinstance(result, (tuple, list)):
            return type(result)(View._own(r, array) for r in result)
        if isinstance(result, np.ndarray) and np.may_share_memory(result, array):
            return result.copy()
        return result

    def __getitem__(self, index):
        array = self._array()
        return self._own(array[index], array)

    def __setitem__(self, index, values):
        array = self._array()
        if not self._writeable:
            raise ValueError(f"{self._what}: can be read only; velocity(block) can be written")
        values = np.asarray(values, dtype=float)
        if not np.isfinite(values).all():
            raise ValueError(f"{self._what}: every value must be finite")
        array[index] = values
        self._simulation()._session_of(self._what).velocities_changed()

    def __array__(self, dtype=None, copy=None):
        if copy is False:
            raise ValueError(f"{self._what}: as an array it is a copy; read the view itself where it lies")
        return np.array(self._array(), dtype=dtype)

    def __array_ufunc__(self, ufunc, method, *inputs, out=None, **named):
        # ufunc.at writes into its first argument, and NumPy does not check that it is writeable.
        if out is not None or method not in READING and isinstance(inputs[0], View):
            raise TypeError(f"{self._what}: no output of {ufunc.__name__}; assign to velocity(block)[...]")
        if not all(isinstance(x, (View, np.ndarray, numbers.Number, np.generic, list, tuple, slice))
                   for x in inputs):
            return NotImplemented
        # Only NumPy's own code has access to the simulation's memory: subclasses of ndarray get copies.
        plain = not any(isinstance(x, np.ndarray) and type(x) is not np.ndarray for x in inputs)
        arrays = [(x._array() if plain else x.copy()) if isinstance(x, View) else x for x in inputs]
        named = {k: v.copy() if isinstance(v, View) else v for k, v in named.items()}
        result = getattr(ufunc, method)(*arrays, **named)
        for array in arrays:
            result = self._own(result, array) if isinstance(array, np.ndarray) else result
        return result

    def __len__(self):
        return len(self._array())

    def __iter__(self):
        return iter(np.array(self._array()))

    def __repr__(self):
        simulation = self._simulation()
        if simulation is None or simulation.closed:
            return f"<view of {self._what}, whose simulation is gone>"
        return f"<view of {self._what}: {np.array2string(self._array(), threshold=20)}>"

    shape = property(lambda self: self._array().shape)
    ndim = property(lambda self: self._array().ndim)
    size = property(lambda self: self._array().size)
    dtype = property(lambda self: self._array().dtype)

    def copy(self):
        return np.array(self._array())

    def _reduction(name):
        def reduce(self, *args, **named):
            return getattr(self._array(), name)(*args, **named)
        reduce.__name__ = name
        return reduce

    min, max, sum, mean, std, any, all, argmin, argmax = map(
        _reduction, ("min", "max", "sum", "mean", "std", "any", "all", "argmin", "argmax"))
    del _reduction
