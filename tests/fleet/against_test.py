"""What --against says of real estimates: corner noise a tenth larger is named with the right sign, draws of the same
noise differ in nothing. against_test.py [DRAWS [FLIGHTS]]; every draw has flights and noise of its own."""
import json
import pathlib
import shutil
import sys
import tempfile

sys.dont_write_bytecode = True
import fleet_fixture as fixture  # noqa: E402


def make(folder, flights, noise_px, seed):
    """The same flights, by their names, with noise of their own."""
    folder.mkdir(parents=True)
    for i in range(flights):
        fixture.call("tagtwist_simulate", "--output", folder / f"flight {i}", "--noimages", "--threads", "1",
                     "--imu_rate", "0", "--duration", "4", "--rate", "20", "--trajectory",
                     ("figure8", "circle", "agile", "hover")[i % 4], "--corner_noise_px", noise_px, "--seed",
                     seed + i)


def estimate(folder, flights, noise_px, seed):
    make(folder / "recordings", flights, noise_px, seed)
    run = fixture.run_fleet(folder / "recordings", folder / "out", more=("--", "--use_detections"))
    if run.returncode:
        sys.exit(run.stderr)
    shutil.rmtree(folder / "recordings")
    return folder / "out"


def named(new, old, table):
    fixture.call("tagtwist_compare", "--collect", "--output", table, "--against", old, new)
    against = json.loads((table / "fleet.json").read_text(encoding="utf-8"))["against"]
    return {entry["figure"]: entry["sign"] for entry in against["named"]}


def main():
    draws = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    flights = int(sys.argv[2]) if len(sys.argv) > 2 else 6
    right = quiet = 0
    for draw in range(draws):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="tagtwist-against-"))
        try:
            old = estimate(folder / "old", flights, 0.1, 1000 * draw + 1)
            worse = named(estimate(folder / "worse", flights, 0.11, 1000 * draw + 301), old, folder / "table")
            same = named(estimate(folder / "same", flights, 0.1, 1000 * draw + 601), old, folder / "table")
            again = named(old, old, folder / "table")
        finally:
            shutil.rmtree(folder)
        print(f"draw {draw}: noise 10 % up: {worse}; the same noise: {same}; the same bytes: {again}", flush=True)
        right += bool(worse) and set(worse.values()) == {"worse"}
        quiet += not same and not again
    print(f"{right} of {draws} named with the right sign, {quiet} of {draws} without a difference named")
    return 0 if right >= 0.95 * draws and quiet >= 0.95 * draws else 1


if __name__ == "__main__":
    if fixture.missing():
        print("skipped:", fixture.missing())
        sys.exit(fixture.SKIP)
    sys.exit(main())
