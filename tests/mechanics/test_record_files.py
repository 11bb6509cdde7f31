"""Records of ground motion read from files of any form, and what a file cannot mean."""

import numpy as np
import pytest

import study

HEADER = "a quake\nsome station\nacceleration in units of g\nNPTS= {}, DT= .02000 SEC\n"


def write_record(path, samples, count=None):
    rows = "\n".join(" ".join(f"{x:9.5f}" for x in samples[i : i + 8]) for i in range(0, len(samples), 8))
    path.write_text(HEADER.format(len(samples) if count is None else count) + rows + "\n")
    return path


def test_a_file_of_peer_is_read_in_metres(tmp_path):
    samples = np.array([0.1, -0.2, 0.3, 0.05, -0.4, 0.25, 0.1, 0.0, 0.2])
    record = study.GroundMotion.read(write_record(tmp_path / "quake.at2", samples), unit="g")
    np.testing.assert_allclose(record.acceleration, np.concatenate([[0], 9.80665 * samples]))
    assert record.title == "quake"


def test_two_columns_are_read_from_any_first_time(tmp_path):
    path = tmp_path / "columns.txt"
    path.write_text("# t a\n0.04, 1.0\n0.05, -2.0\n0.06, 0.5\n")
    record = study.GroundMotion.read(path, unit="cm/s2")
    np.testing.assert_allclose(record.acceleration, [0, 0, 0, 0, 0.01, -0.02, 0.005])
    assert record.dt == pytest.approx(0.01)


@pytest.mark.parametrize(
    "stated, unit",
    [("G,", "g"), ("CM/S**2", "cm/s2"), ("cm/s^2", "cm/s2"), ("cm/sec/sec", "cm/s2"), ("Gal", "cm/s2"), ("ells", "g")],
)
def test_units_of_headers_are_known_by_any_spelling(tmp_path, stated, unit):
    path = write_record(tmp_path / "quake.at2", np.array([0.1, -0.2, 0.3]))
    path.write_text(path.read_text().replace("units of g", f"UNITS OF {stated}"))
    assert len(study.GroundMotion.read(path, unit=unit).acceleration) == 4


@pytest.mark.parametrize(
    "header",
    [
        "NPTS=  4, DT= .00500 SEC",
        "NPTS=  4, DT= .00500 SEC\nand a fifth line of the header",
        "npts=4 dt=0.005",
        "DT= 0.005, NPTS= 4",
        "  4  .0050  NPTS, DT",
        "4 0.0050 NPTS DT",
        "  0.0050  4  DT, NPTS",
        "NPTS, DT\n  4,  .5000E-02",
        "NPTS  DT (SEC)\n  4  5D-3",
    ],
)
def test_every_form_of_the_header_of_peer_is_read(tmp_path, header):
    path = tmp_path / "old.at2"
    path.write_text(f"\ufeffa\nb\nunits of g\n{header}\n.1000E+00 -0.2D0 +.3\n-.12-103\n", encoding="utf-8")
    record = study.GroundMotion.read(path)
    assert record.dt == 0.005
    np.testing.assert_allclose(record.acceleration, 9.80665 * np.array([0.0, 0.1, -0.2, 0.3, -1.2e-104]), rtol=1e-15)


@pytest.mark.parametrize("between", [" ", ",", ", ", "\t", ";", "  ;  "])
@pytest.mark.parametrize(
    "heading", ["", "time,acc\n", "# t a\n% of a station\n", "\ntime [s]; acceleration [cm/s^2]\n"]
)
def test_columns_are_read_with_any_heading_and_separator(tmp_path, between, heading):
    path = tmp_path / "columns.csv"
    rows = [f"{t}{between}{a}" for t, a in (("0.00", "1.0"), ("0.01", "-2.0  # peak"), ("0.02", ".5"))]
    path.write_text(heading + "\n".join(rows) + "\n\n")
    unit = None if "[" in heading else "cm/s2"
    record = study.GroundMotion.read(path, unit)
    np.testing.assert_allclose(record.acceleration, [0.01, -0.02, 0.005])
    assert record.dt == pytest.approx(0.01)


def test_one_column_begins_at_zero_and_needs_the_time_between_samples(tmp_path):
    path = tmp_path / "path.txt"
    path.write_text("acc\n0.1\n-0.2\n0.3\n")
    record = study.GroundMotion.read(path, unit="g", dt=0.02)
    np.testing.assert_allclose(record.acceleration, 9.80665 * np.array([0.1, -0.2, 0.3]))
    assert record.dt == 0.02
    path.write_text("0 0.1\n0.01 -0.2\n0.02 0.3\n")
    assert study.GroundMotion.read(path, unit="g", dt=0.01).dt == pytest.approx(0.01)
    with pytest.raises(ValueError, match="are 0.01 s apart, not dt=0.02"):
        study.GroundMotion.read(path, unit="g", dt=0.02)
    with pytest.raises(ValueError, match="dt must be a time in s greater than zero, not 0"):
        study.GroundMotion.read(path, unit="g", dt=0)


@pytest.mark.parametrize(
    "heading",
    [
        *("dt = 0.005 s", "dt is DT=5 ms", "step dt: 5e-3", "# time step 0.005 s, unit g", "sampling rate: 200 Hz"),
        *("sampling rate = 2e2 Hz", "sampling frequency = 0.2 kHz", "sampling period (dt) and dt 0.005 (s)"),
    ],
)
def test_a_time_between_samples_is_not_another_one_than_the_file_states(tmp_path, heading):
    path = tmp_path / "record.txt"
    for rows in (".1\n-.2\n.3\n", "0 .1\n.02 -.2\n.04 .3\n"):
        path.write_text(f"{heading}\n{rows}")
        with pytest.raises(ValueError, match=r"states samples 0\.005 s apart, and they are 0\.02 s apart"):
            study.GroundMotion.read(path, unit="g", dt=0.02)
    path.write_text(f"{heading}\n.1\n-.2\n.3\n")
    assert study.GroundMotion.read(path, unit="g", dt=0.005).dt == pytest.approx(0.005)


def test_a_number_of_samples_and_their_spacing_may_precede_them(tmp_path):
    path = tmp_path / "record.txt"
    path.write_text("3 .005\n.1\n-.2\n.3\n")
    assert study.GroundMotion.read(path, unit="g").dt == 0.005
    with pytest.raises(ValueError, match="are 0.005 s apart, not dt=0.02"):
        study.GroundMotion.read(path, unit="g", dt=0.02)


@pytest.mark.parametrize(
    "heading",
    [
        *("dt=5 us", "sampling interval: 5 min", "dt = 1,5 ms", "dt=1/200", "sample rate 1/200", "time step 1 of 3"),
        *(
            "time interval 10-30 s",
            "time step = 10 -3 s",
            "sampling rate = 0.005 s",
            "period 0.3 s",
            "band 0.1 to 25 Hz",
        ),
        "original sampling rate 100 Hz, resampled to sampling rate 200 Hz",
    ],
)
def test_words_that_state_no_clear_time_between_samples_are_no_reason_to_refuse(tmp_path, heading):
    path = tmp_path / "record.txt"
    path.write_text(f"{heading}\n.1\n-.2\n.3\n")
    assert study.GroundMotion.read(path, unit="g", dt=0.005).dt == 0.005
    with pytest.raises(ValueError, match="has one column: give the time between its samples"):
        study.GroundMotion.read(path, unit="g")


KNET = """Origin Time       2011/03/11 14:46:00
Lat.              38.103
Long.             142.861
Depth. (km)       24
Mag.              9.0
Station Code      MYG004
Station Lat.      38.7292
Station Long.     141.0217
Station Height(m) 40
Record Time       2011/03/11 14:46:51
Sampling Freq(Hz) 100Hz
Duration Time(s)  {seconds}
Dir.              N-S
Scale Factor      3920(gal)/6182761
Max. Acc. (gal)   2.1
Last Correction   2011/03/11 14:46:36
Memo.
"""
ESM = """EVENT_NAME: EMILIA
EVENT_ID: IT-2012-0008
STATION_CODE: MRN
LATE/NORMAL_TRIGGERED: NT
SAMPLING_INTERVAL_S: 0.005000
NDATA: 5
DURATION_S: 0.020
UNITS: cm/s^2
PGA_CM/S^2: -3.5
DATA_TYPE: ACCELERATION
USER5:
"""


def test_a_file_of_k_net_is_read_without_the_offset_of_its_instrument(tmp_path):
    path = tmp_path / "MYG0041103111446.NS"
    counts = 5000 + np.round(3000 * np.sin(np.arange(200))).astype(int)
    rows = "\n".join(" ".join(f"{count:8d}" for count in counts[i : i + 8]) for i in range(0, 200, 8))
    path.write_text(KNET.format(seconds=2) + rows + "\n")
    record = study.GroundMotion.read(path)
    assert record.dt == 0.01 and len(record.acceleration) == 200
    np.testing.assert_allclose(record.acceleration, (counts - counts.mean()) * 3920 / 6182761 / 100, atol=1e-15)
    assert "MYG004" in record.source and record.acceleration.mean() == pytest.approx(0, abs=1e-15)
    path.write_text(KNET.format(seconds=3) + rows)
    with pytest.raises(ValueError, match="announces 300 samples, and the file holds 200"):
        study.GroundMotion.read(path)
    path.write_text((KNET.format(seconds=2) + rows).replace("3920(gal)/6182761", "unknown"))
    with pytest.raises(ValueError, match=r"the header of '.*' lacks the value of 'Scale Factor'"):
        study.GroundMotion.read(path)


def test_a_file_of_esm_is_read(tmp_path):
    path = tmp_path / "IT.MRN..HGE.ACC.MP.ASC"
    path.write_text(ESM + "0.5\n-3.5\n1.0e+00\n0.25\n0\n")
    record = study.GroundMotion.read(path)
    np.testing.assert_allclose(record.acceleration, [0.005, -0.035, 0.01, 0.0025, 0.0])
    assert record.dt == 0.005 and record.source == "EMILIA, IT-2012-0008, MRN"
    with pytest.raises(ValueError, match="states the unit cm/s2, not 'g'"):
        study.GroundMotion.read(path, unit="g")
    path.write_text(ESM.replace("ACCELERATION", "VELOCITY") + "0.5\n")
    with pytest.raises(ValueError, match="announces velocity, and a record of acceleration is needed"):
        study.GroundMotion.read(path)
    path.write_text(ESM.replace("ACCELERATION", "ACCELERATION RESPONSE SPECTRUM") + "0.5\n")
    with pytest.raises(ValueError, match="announces a spectrum, and a record of acceleration is needed"):
        study.GroundMotion.read(path)


@pytest.mark.parametrize(
    "heading, rows, sentence",
    [
        ("Time [ms],Acceleration [m/s2]", "0,1\n10,-2\n20,0.5", ""),
        ("t (MSEC) a (m/s^2)", "0 1\n10 -2\n20 0.5", ""),
        ("time_ms;acc", "0;1\n10;-2\n20;0.5", ""),
        ("time,acc\n(ms),(m/s2)", "0,1\n10,-2\n20,0.5", ""),
        ("ms,m/s2", "0,1\n10,-2\n20,0.5", ""),
        ("Time [sec] Acc [m/s/s]", "0 1\n0.01 -2\n0.02 0.5", ""),
        ("# acc,time", "1,0\n-2,0.01\n0.5,0.02", ""),
        ("acceleration [m/s2]\ttime [ms]", "1\t0\n-2\t10\n0.5\t20", ""),
        ("time series of acceleration\norigin time\nt a", "0 1\n0.01 -2\n0.02 0.5", ""),
        ("acceleration time history of a station\nt a", "0 1\n0.01 -2\n0.02 0.5", ""),
        ("time [min],acc", "0,1\n10,-2", "states times in 'min', and they must be in s, sec, ms or msec"),
        ("time,disp", "0,1\n1,2", "announces displacement, and a record"),
        ("time,vel (m/s)", "0,1\n1,2", "announces velocity, and a record"),
        ("t,v", "0,1\n1,2", "announces velocity, and a record"),
    ],
)
def test_a_heading_names_the_order_and_the_units_of_columns(tmp_path, heading, rows, sentence):
    path = tmp_path / "columns.csv"
    path.write_text(f"{heading}\n{rows}\n")
    if sentence:
        with pytest.raises(ValueError, match=sentence):
            study.GroundMotion.read(path, "m/s2")
        return
    record = study.GroundMotion.read(path, "m/s2")
    assert record.dt == pytest.approx(0.01)
    np.testing.assert_allclose(record.acceleration, [1, -2, 0.5])


@pytest.mark.parametrize(
    "header",
    [
        "NPTS= 3, DT= 10 MSEC",
        "NPTS=3, DT=.01SEC",
        "NPTS=3, DT=0.01s",
        "npts=3, dt=0.01sec, corrected",
        "NPTS= 3, DT (MS)= 10",
        "NPTS= 3, DT= .1000E-01SEC",
        "DT= 10 ms NPTS= 3",
        "dt=0.01 npts=3",
        "dt=.01 (sec) npts=3",
        "NPTS, DT (MSEC)\n3, 10",
        "3 10. NPTS, DT MSEC",
    ],
)
@pytest.mark.parametrize("unit", ["UNITS: CM/SEC/SEC", "acceleration (cm/s^2)"])
def test_a_file_of_peer_may_state_milliseconds_and_full_columns(tmp_path, header, unit):
    path = tmp_path / "quake.at2"
    path.write_text(f"a quake\nstation\n{unit}\n{header}\n 0.1000E+03-0.2000E+03\n-0.3000E+02\n")
    record = study.GroundMotion.read(path)
    assert record.dt == pytest.approx(0.01)
    np.testing.assert_allclose(record.acceleration, [0.0, 1.0, -2.0, -0.3])


def test_rows_without_a_heading_are_read_one_after_the_other_if_they_hold_no_times(tmp_path):
    path = tmp_path / "stripped.at2"
    path.write_text(".1 -.2 .3 .4 .5\n-.6 .7 .8 .9 1.\n.3 .2\n")
    record = study.GroundMotion.read(path, "m/s2", dt=0.01)
    np.testing.assert_allclose(record.acceleration, [0.1, -0.2, 0.3, 0.4, 0.5, -0.6, 0.7, 0.8, 0.9, 1.0, 0.3, 0.2])
    for table in ("0 .1 .2 .3\n.01 .2 .3 .4\n.02 .2 .3 .4\n", "0 .1 .2 .3\n.01 .2 .3 .4\n", ".1 .2 .3 .4\n.2\n.3 .4\n"):
        path.write_text(table)
        with pytest.raises(ValueError, match="is no file of PEER, ESM or K-NET and has"):
            study.GroundMotion.read(path, "m/s2", dt=0.01)


@pytest.mark.parametrize(
    "text, unit, sentence",
    [
        (HEADER.format(3) + "0.1 0.2\n", "g", "announces 3 samples, and the file holds 2"),
        (HEADER.format(2) + "0.1 nan\n", "g", "row 5 of '.*' holds 'nan', which is not a finite number"),
        (HEADER.format(2) + "0.1 x\n", "g", "row 5 of '.*' holds 'x', which is not a finite number"),
        (HEADER.format(2) + "0.1 0.2\n", "cm/s2", "states the unit g, not 'cm/s2'"),
        (HEADER.format(2).replace("of g", "OF G,") + "0.1 0.2\n", "m/s2", "states the unit g, not 'm/s2'"),
        (HEADER.format(2).replace("of g", "of CM/SEC/SEC") + "0.1 0.2\n", "g", "states the unit cm/s2, not 'g'"),
        (
            HEADER.format(2).replace("acceleration", "VELOCITY") + "0.1 0.2\n",
            "g",
            "announces velocity, and a record",
        ),
        (HEADER.format(2).replace("SEC", "MIN") + "0.1 0.2\n", "g", "states times in 'MIN', and they must be in s"),
        (HEADER.format(0), "g", "announces no samples"),
        (HEADER.format(2).replace("DT= .02000", "DT= .") + "0.1 0.2\n", "g", "must state both NPTS and DT"),
        (HEADER.format(2).replace("DT= .02000", "DT= 1/200") + "0.1 0.2\n", "g", "must state both NPTS and DT"),
        ("0 300\n1 -1\n", "g", "the peak of '.*' would be 300 g in the unit 'g'"),
        ("0 1\n1 2\n3 4\n4 5\n", "g", "must be a constant time apart, and are not after t = 1"),
        ("1 2 3\n4 5 6\n", "g", "is no file of PEER, ESM or K-NET and has"),
        ("0 1\n1 2\n", "furlong", "unit must be one of g, m/s2"),
        ("0 1\n1 2\n", None, "does not state its unit: give unit= as one of g, m/s2"),
        ("t (s),a (m/s2)\n0,1\n1,2\n", "g", "states the unit m/s2, not 'g'"),
        ("time,velocity\n0,1\n1,2\n", "g", "announces velocity, and a record of acceleration is needed"),
        ("0.1\n0.2\n", "g", "has one column: give the time between its samples in s, such as dt=0.01"),
        ("# t a\n" + "".join(f"{i} 0.1\n" for i in range(19)) + "19 1e999\n", "g", "row 21 of '.*' holds '1e999'"),
        ("time acc\n" + "".join(f"{i} 0.1\n" for i in range(19)) + "19 n/a\n", "g", "row 21 of '.*' holds 'n/a'"),
        ("0 1\n1\n2 1\n", "g", "row 2 of '.*' has 1 numbers, and the first row 2"),
        ("gap 0.1\n1 2\n2 3\n", "g", "row 1 of '.*' holds 'gap', which is not a finite number"),
        ("no numbers\n", "g", "is no file of PEER, ESM or K-NET and has no columns"),
        (HEADER.format(2).replace("NPTS= 2,", "NPTS= 2.5,") + "0.1 0.2\n", "g", "must state both NPTS and DT"),
        (HEADER.format("1_000") + "0.1 0.2\n", "g", "must state both NPTS and DT"),
    ],
)
def test_records_that_cannot_be_right_get_a_sentence(tmp_path, text, unit, sentence):
    path = tmp_path / "record"
    path.write_text(text)
    with pytest.raises(ValueError, match=sentence):
        study.GroundMotion.read(path, unit=unit)


ONE = [0.1, -0.2, 0.3, -0.4, 0.5, 0.6]
ROWS = [f"{k * 0.0078125:.3f} {value}" for k, value in enumerate(ONE)]


@pytest.mark.parametrize(
    "lines, options",
    [
        (["6 0.0078125", *map(str, ONE)], {}),
        (["6 0.0078125", *(f"{k * 0.0078125} {value}" for k, value in enumerate(ONE))], {}),
        (["6", *map(str, ONE)], {"dt": 0.0078125}),
        (["Station 1979", "horizontal", *map(str, ONE)], {"dt": 0.0078125}),
        (["time;acc", *(f"{k * 0.0078125};{value}".replace(".", ",") for k, value in enumerate(ONE))], {}),
        (ROWS, {"dt": 0.0078125}),
    ],
    ids=["count and spacing", "count and times", "count", "year", "decimal commas", "rounded times"],
)
def test_forms_of_columns_give_the_same_record(tmp_path, lines, options):
    path = tmp_path / "record.txt"
    path.write_text("\n".join(lines))
    record = study.GroundMotion.read(path, unit="m/s2", **options)
    np.testing.assert_allclose(record.acceleration, ONE)
    assert float(record.dt) == pytest.approx(0.0078125)


@pytest.mark.parametrize(
    "lines, message",
    [
        (["n,acc", *(f"{k},{value}" for k, value in enumerate(ONE))], "numbers its samples .* give dt="),
        (ROWS, "if the times are rounded, give dt="),
        ([f"{k * 0.1 - 0.2:.1f} {value}" for k, value in enumerate(ONE)], "must begin at zero or later"),
        (["1 2 3", "4 5 6"], "has 3 columns of numbers"),
        ([*ROWS[:3], *(f"{(k + 1) * 0.0078125:.3f} {ONE[k]}" for k in (3, 4, 5))], "constant time apart"),
    ],
    ids=["numbers", "rounded", "before zero", "three columns", "a row is missing"],
)
def test_columns_that_are_no_record_are_refused_with_a_way_out(tmp_path, lines, message):
    path = tmp_path / "record.txt"
    path.write_text("\n".join(lines))
    options = {"dt": 0.0078125} if message == "constant time apart" else {}
    with pytest.raises(ValueError, match=message):
        study.GroundMotion.read(path, unit="m/s2", **options)
