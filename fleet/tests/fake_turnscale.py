#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""A stand-in for the program in tests: does what the name of its input says."""
import json
import os
import pathlib
import sys
import time

words = sys.argv[1:]
out = pathlib.Path(next(word.removeprefix("--out=") for word in words if word.startswith("--out=")))
source = pathlib.Path(next(word for word in words[1:] if not word.startswith("--")))
what, *more = source.name.split("-")

# Every start leaves a file, so that tests can count them.
starts = source.parent / "starts"
starts.mkdir(exist_ok=True)
(starts / f"{source.name}-{os.getpid()}").touch()

out.mkdir(parents=True, exist_ok=True)
(out / "trajectory.tum").write_text(f"half of {source.name}")
if what == "sleep":
    time.sleep(float(more[0]))
elif what == "hang":
    time.sleep(3600)
elif what == "bad":
    print(f"turnscale: {source}: cannot be read", file=sys.stderr)
    sys.exit(2)
elif what == "full":
    print(f"turnscale: {out}/trajectory.tum: No space left on device", file=sys.stderr)
    sys.exit(1)
elif what == "write":
    # So many MB; a full disk is a failure.
    try:
        (out / "map.ply").write_bytes(os.urandom(int(float(more[0]) * 1e6)))
    except OSError as error:
        print(f"turnscale: {error.filename}: {error.strerror}", file=sys.stderr)
        sys.exit(1)
elif what == "crash":
    os.abort()
elif what == "once":
    # Kills its worker the first time.
    if len(list(starts.glob(f"{source.name}-*"))) == 1:
        os.kill(os.getppid(), 9)
        time.sleep(3600)
elif what == "deadly":
    os.kill(os.getppid(), 9)
    time.sleep(3600)
(out / "trajectory.tum").write_text(f"whole of {source.name}")
summary = {"frames": {"total": 10, "tracked": 9}, "distance_m": 12.5, "path_sigma": 0.02, "missing": {"of_s": 1.0},
           "scale": {"state": "held", "known": True}, "turns": {"found": 2, "used": 1}, "warnings": [],
           "arguments": [word for word in words if not word.startswith("--out=")]}
if what == "car":
    # A drive that tells c, as `run` does.
    prior = [[0.0027, 0, 0, 0], [0, 4e-6, 0, 0], [0, 0, 4e-4, 0], [0, 0, 0, 1]]
    posterior = [[0.0027, 0, 0, 0], [0, 1e-6, 0, 0], [0, 0, 4e-4, 3.9e-4], [0, 0, 3.9e-4, 8e-4]]
    summary |= {"car_evidence": {"prior": {"mean": [0, 0.0045, 0.4, 0.3], "covariance": prior},
                                 "posterior": {"mean": [0, float(more[0]), 0.4, 0.34], "covariance": posterior},
                                 "inflation": 1},
                "camera_rotation": {"source": "assumed", "moves": []}, "camera_yaw_pitch_roll_deg": [0, 0, 0],
                "lever_arm_m": 1.5}
(out / "summary.json").write_text(json.dumps(summary))
