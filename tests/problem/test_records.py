"""Stochastic records of given spacing, corner frequency and decay."""

import numpy as np
import pytest

from study.mechanics.ground import GroundMotion
from study.problem.records import FINEST, family, files_in, point_source


def test_the_power_follows_the_source_and_the_decay():
    corner, kappa, frequencies = 0.5, 0.03, np.array([1.0, 4.0, 15.0])
    records = [point_source(seed, FINEST, corner, kappa, 10.0).acceleration for seed in range(60)]
    power = np.mean(np.abs(np.fft.rfft(np.stack(records))) ** 2, axis=0)
    f = np.fft.rfftfreq(len(records[0]), FINEST)
    powers = np.array([power[np.abs(f - frequency) < 0.3].mean() for frequency in frequencies])
    expected = (frequencies**2 / (1 + (frequencies / corner) ** 2) * np.exp(-np.pi * kappa * frequencies)) ** 2
    assert powers / powers[0] == pytest.approx(expected / expected[0], rel=0.15)


def test_a_coarse_record_is_the_fine_one_without_what_its_samples_would_alias():
    fine, coarse = (point_source(3, spacing, 0.5, 0.005, 5.0).acceleration for spacing in (FINEST, 0.02))
    spectrum = np.fft.rfft(fine)
    slow = np.fft.irfft(np.where(np.fft.rfftfreq(len(fine), FINEST) < 25, spectrum, 0), len(fine))
    likeness = [np.corrcoef(coarse, record[::8])[0, 1] for record in (slow, fine)]
    assert likeness[0] > 0.999 > 0.95 > likeness[1]
    assert np.abs(coarse).max() == pytest.approx(3.0)


def test_a_folder_without_records_is_refused(tmp_path):
    (tmp_path / ".hidden").touch()
    (tmp_path / "README.md").write_text("terms of use")
    (tmp_path / "folder").mkdir()
    for folder, sentence in ((tmp_path, "holds no file"), (tmp_path / "none", "there is no folder")):
        with pytest.raises(ValueError, match=sentence):
            files_in(folder)


def test_a_family_holds_the_measured_records_and_all_combinations():
    members, measured = family([0.01, 0.02], [0.2, 1.0], [0.02], 3, 2.0), GroundMotion.measured()
    assert len(members) == len(measured) + 2 * 2 * 3 and len({member.title for member in members}) == len(members)
    for member, record in zip(members, measured, strict=False):
        a, whole = np.asarray(member.acceleration), np.asarray(record.acceleration)
        assert member.source and member.duration == pytest.approx(2.0)
        energies = [np.sum(whole[first : first + len(a)] ** 2) for first in range(0, len(whole) - len(a) + 1, 5)]
        assert np.sum(a**2) >= max(energies) * (1 - 1e-12)
