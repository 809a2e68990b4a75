"""Writes the files of this folder: one test of a contact by the libraries that people use, none of which is ours.

    python3 -m venv v && v/bin/pip install numpy==2.4.6 scipy==1.17.1 npTDMS==1.13.0 pyuff==2.5.8 && v/bin/python write.py

Displacement 4 um sin, tangential force 30 N of the sign of its rate, normal force 100 N + 2 N cos; 60 samples of 10 kHz.
"""

import pathlib

import numpy as np
import pyuff
import scipy.io
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

i = np.arange(60)
time = i * 1e-4
phase = 2 * np.pi * i / 20
signals = [
    ("displacement", "um", 4 * np.sin(phase)),
    ("tangential force", "N", 30 * np.clip(4 * np.cos(phase), -1, 1) + 6 * np.sin(phase)),
    ("normal force", "N", 100 + 2 * np.cos(phase)),
]

for compressed in (False, True):
    name = "scipy-compressed.mat" if compressed else "scipy.mat"
    fields = {key.replace(" ", "_") + "_" + unit: values for key, unit, values in signals}
    scipy.io.savemat(name, {"A1": {"time_s": time, **fields}, "note": "of no use"}, do_compression=compressed)

with TdmsWriter("nptdms.tdms") as writer:
    for part in (slice(0, 25), slice(25, 60)):
        channels = [
            ChannelObject("A1", key, values[part], {"unit_string": unit, "wf_increment": 1e-4, "wf_start_offset": 0.0})
            for key, unit, values in signals
        ]
        writer.write_segment([RootObject({"specimen": "S"}), GroupObject("A1"), *channels])

for binary in (0, 1):
    name = "pyuff-58b.uff" if binary else "pyuff.uff"
    sets = [
        {
            "type": 58, "binary": binary, "id1": key, "id2": "A1", "id3": "specimen = S", "id4": "NONE", "id5": "NONE",
            "func_type": 1, "ver_num": 0, "load_case_id": 0, "rsp_ent_name": "NONE", "rsp_node": 1, "rsp_dir": 1,
            "ref_ent_name": "NONE", "ref_node": 1, "ref_dir": 1, "ord_data_type": 4, "num_pts": len(time),
            "abscissa_spacing": 1, "abscissa_min": 0.0, "abscissa_inc": 1e-4, "z_axis_value": 0.0,
            "abscissa_spec_data_type": 17, "abscissa_axis_lab": "Time", "abscissa_axis_units_lab": "s",
            "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "ordinate_spec_data_type": 8 if unit == "um" else 13,
            "ordinate_axis_lab": key, "ordinate_axis_units_lab": unit, "x": time, "data": values,
        }
        for key, unit, values in signals
    ]
    # "overwrite" of pyuff 2.5.8 loses the first binary set
    pathlib.Path(name).unlink(missing_ok=True)
    pyuff.UFF(name).write_sets(sets, "add")
