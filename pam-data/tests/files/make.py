"""Makes the files of this folder: `python make.py` (NumPy 2, SciPy 1)."""

import numpy as np
from scipy.io import savemat

table = np.arange(6.0).reshape(2, 3) / 7
arrays = {
    "x": table,
    "k": np.array([-3, 0, 70000], dtype=np.int32),
    "u": np.array([200], dtype=np.uint8),
    "f": np.array([0.5, -2.0], dtype=np.float32),
    "z": np.array([1.0 + 2.0j]),
    "text": "a text",
    "fields": {"a": 1.0},
}
savemat("plain.mat", arrays)
savemat("packed.mat", arrays, do_compression=True)

np.save("c_order.npy", table)
np.save("fortran.npy", np.asfortranarray(table))
np.save("big_endian.npy", table.astype(">f8"))
np.save("integers.npy", np.array([-3, 0, 70000], dtype=np.int32))
np.save("bytes.npy", np.array([True, False]))
np.save("texts.npy", np.array(["ν", "long name", ""]))
np.save("complex.npy", np.array([1.0 + 2.0j]))
np.save("scalar.npy", np.float64(-0.1))
with open("version_2.npy", "wb") as file:
    np.lib.format.write_array(file, table, version=(2, 0))
np.savez_compressed("packed.npz", x=table, names=np.array(["a", "b"]))
