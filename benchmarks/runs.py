# SPDX-License-Identifier: MIT
"""What the benchmarks on drives share: rendering, running, scoring, and the tables of their pages."""
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

# Half of the default size, for the sake of time.
HALF_SIZE_CAMERA = {"width": 516, "height": 386, "fx": 307.5, "fy": 307.5, "cx": 257.5, "cy": 192.5}

# Recorded drives by their folder in the data: what carries the images, lever arm (m), side slip (s^2/m).
RECORDED = {
    "kitti_07_f000-159": ("", 0.945, 0.0041),
    "kitti_05_f100-159": ("", 0.945, 0.0041),
    "kitti_03": ("video.mkv", 0.945, 0.0041),
    "torcs_dirt3_uturn": ("video.mkv", 1.5, 0.0084),
    "torcs_alpine1_r3p5y12": ("video.mkv", 1.7, 0.0060),
}
KITTI_HEIGHT = 1.65  # of its camera above the road, metres, according to the data set's page


def fail(message):
    sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {message}")


def run(command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode != 0:
        fail(f"{' '.join(map(str, command))}\n{result.stderr.strip()}")
    return result.stdout


def say(text):
    print(text, file=sys.stderr, flush=True)


def machine():
    cpu = re.search(r"model name\s*: (.*)", pathlib.Path("/proc/cpuinfo").read_text())
    return f"{os.cpu_count()} cores, {cpu.group(1) if cpu else 'unknown'}"


def read_yaml(path):
    """The flat maps that simulate writes."""
    values = {}
    for line in path.read_text().splitlines():
        if ":" in line and not line.startswith("#"):
            key, value = line.split("#")[0].split(":", 1)
            values[key.strip()] = value.strip()
    return values


def height_of(drive):
    """Of a recorded drive's camera above the road, metres."""
    about = drive / "vehicle.yaml"
    return float(read_yaml(about)["camera_height_m"]) if about.is_file() else KITTI_HEIGHT


def times_of(drive):
    """Of its images, seconds."""
    return [float(line) for line in (drive / "times.txt").read_text().split()]


def ffmpeg_input(drive, rate):
    """Arguments of ffmpeg that read its images, so many a second."""
    video = drive / "video.mkv"
    return ["-r", rate, *(["-i", video] if video.is_file() else
                          ["-pattern_type", "glob", "-i", drive / "image_0" / "*.png"])]


def poses_of(path):
    """3x4 matrices, row by row."""
    return [[float(word) for word in line.split()] for line in path.read_text().splitlines()]


def hashed(*parts):
    """One number for texts and for the contents of files."""
    whole = hashlib.sha256()
    for part in parts:
        data = part.read_bytes() if isinstance(part, pathlib.Path) else str(part).encode()
        whole.update(len(data).to_bytes(8, "big") + data)
    return whole.hexdigest()


def rig_text(rig):
    return "".join(f"{key}:\n" + "".join(f"  {k}: {v}\n" for k, v in fields.items()) if isinstance(fields, dict)
                   else f"{key}: {fields}\n" for key, fields in rig.items())


def rendered(program, folder, arguments, rig):
    """The drive that simulate makes of these arguments, rendered where the folder does not hold it yet. A newer program
    does not make it anew."""
    wanted = hashed(rig_text(rig), *arguments)
    made_of = folder / "made_of"
    if (folder / "times.txt").is_file() and made_of.is_file() and made_of.read_text() == wanted:
        return folder
    say(f"rendering {folder.name}")
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    rig_file = folder.with_name(f"{folder.name}.yaml")
    rig_file.write_text(rig_text(rig))
    run([program, "simulate", *arguments, *(["--rig", rig_file] if rig else []), "--out", folder, "--quiet"])
    rig_file.unlink()
    made_of.write_text(wanted)
    return folder


def section(part, made, before):
    """A part of a page between marks. Where nothing was made, it is what the page says before."""
    begin, end = f"<!-- {part} -->\n", f"<!-- end of {part} -->\n"
    return begin + (made or before.partition(begin)[2].partition(end)[0] or "Not measured yet.\n") + end


def estimated_intrinsics(summary):
    """None where the intrinsics were given or assumed."""
    intrinsics = summary.get("intrinsics") or {}
    return intrinsics if intrinsics.get("source") in ("estimated", "refined") else None


def run_and_score(program, images, truth, out, options):
    """Runs a drive by these options and scores it: a map of numbers, fit for JSON.

    `failed` is what the run says where it comes to nothing. A path that is not in metres has no `path_percent`, one
    without a pose no `ate_m` either; `sigma_percent` is that of the path's length.
    """
    shutil.rmtree(out, ignore_errors=True)
    command = [str(word) for word in (program, "run", images, *options, "--out", out, "--quiet")]
    result = subprocess.run(command, capture_output=True, text=True)
    score = {"options": [str(word) for word in options], "printed": result.stderr.strip().splitlines()}
    if result.returncode != 0:
        return {**score, "failed": score["printed"][-1] if score["printed"] else f"exit code {result.returncode}"}
    summary = json.loads((out / "summary.json").read_text())
    scale = summary["scale"]
    # Before the path's own sigma there was the last frame's only.
    sigma = summary.get("path_sigma", scale.get("relative_sigma"))
    car = summary.get("by_all_turns") or {}
    score |= {
        "metric": summary["distance_m"] is not None, "scale_state": scale["state"],
        "sigma_percent": None if sigma is None else 100 * sigma, "warnings": summary.get("warnings", []),
        "frames": summary["frames"], "turns": summary["turns"], "cost": summary["cost"],
        "side_slip": car.get("side_slip_s2_per_m"), "side_slip_sigma": car.get("side_slip_sigma_s2_per_m"),
        "camera_yaw_pitch_roll_deg": summary["camera_yaw_pitch_roll_deg"], "intrinsics": estimated_intrinsics(summary),
        "path_percent": None, "ate_m": None, "metres": None,
    }
    if not (out / "trajectory.tum").read_text().strip():
        return score
    errors = json.loads(run([program, "evaluate", out / "trajectory.tum", truth, "--json", "-"]))
    score["metres"] = errors["true_path_length_m"]
    score["ate_m"] = (errors["position_error"]["sim3"] or {}).get("rmse_m")
    if score["metric"]:
        score["path_percent"] = errors["as_given"]["path_length_error_percent"]
    return score


def calibration_reports(score):
    """The warnings of a run that the images contradict its calibration."""
    return [warning for warning in score.get("warnings", []) if warning.startswith("the images taken in turns give a ")]


def is_outside(score):
    """Whether the error of the path's length is above two stated sigmas. No sigma claims nothing."""
    error, sigma = score.get("path_percent"), score.get("sigma_percent")
    return error is not None and sigma is not None and abs(error) > 2 * sigma


def percent_tracked(score):
    """Frames with a pose of their own, or that repeat one that has."""
    frames = score["frames"]
    return 100 * (frames["tracked"] + frames["repeated"]) / frames["total"]


def cached(file, made_of, make):
    """What `make` gave before of the same, or gives now: a map that the file keeps as JSON."""
    if file.is_file():
        kept = json.loads(file.read_text())
        if kept["made_of"] == made_of:
            return kept
    value = {"made_of": made_of, **make()}
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_text(json.dumps(value, indent=2) + "\n")
    part.rename(file)
    return value


def cell(value, digits=1, sign=False):
    return "" if value is None else f"{value:{'+' if sign else ''}.{digits}f}"


def path_cell(score):
    """Error of the path's length and its stated sigma; bold where it is above two of them."""
    if score["path_percent"] is None:
        return "no metres"
    text = f"{cell(score['path_percent'], sign=True)} / {cell(score['sigma_percent'])}"
    return f"**{text}**" if is_outside(score) else text


def table(header, rows):
    align = "|".join([":--"] + ["--:"] * (len(header) - 1))
    lines = ["| " + " | ".join(header) + " |", f"|{align}|", *("| " + " | ".join(row) + " |" for row in rows)]
    return "\n".join(lines) + "\n"
