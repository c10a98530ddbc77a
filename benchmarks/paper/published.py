"""What the paper reports: Langlois and James, Inverse-Foley Animation, ACM TOG 33(4), 2014."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Table1Row:
    """A row of Table 1: 400,000 simulations, recorded sounds, four Xeon 7560.

    marks: their mean number. solved of sounds have succeeded; minutes (of search) and score are
    means over those.
    """

    nodes: int
    marks: float
    solved: int
    sounds: int
    minutes: float
    score: float


TABLE_1 = {
    ("adjustable_wrench", "desk"): Table1Row(2556981, 5.5, 13, 13, 0.9, 0.43),
    ("beer_can", "wood"): Table1Row(1462089, 2.9, 15, 15, 0.6, 0.35),
    ("bolt", "desk"): Table1Row(2604880, 5.6, 7, 7, 14.5, 0.25),
    ("carton", "desk"): Table1Row(1282526, 4.1, 25, 29, 1.3, 0.32),
    ("coat_hanger", "desk"): Table1Row(4759056, 6.4, 18, 19, 9.3, 0.46),
    ("coffee_cup", "desk"): Table1Row(5710615, 7.1, 15, 16, 38.2, 0.24),
    ("card", "desk"): Table1Row(1965526, 4.4, 22, 23, 6.8, 0.44),
    ("d4", "desk"): Table1Row(3750746, 15.7, 6, 10, 62.7, 0.17),
    ("d6", "desk"): Table1Row(6751058, 20.4, 13, 14, 12.1, 0.41),
    ("d8", "desk"): Table1Row(4867818, 22.0, 6, 12, 53.9, 0.27),
    ("d10", "desk"): Table1Row(7623610, 25.7, 11, 14, 18.6, 0.38),
    ("d12", "desk"): Table1Row(9934621, 26.0, 4, 7, 24.2, 0.39),
    ("d20", "desk"): Table1Row(9427739, 26.8, 9, 10, 37.7, 0.31),
    ("dustpan", "wood"): Table1Row(4520601, 6.7, 6, 6, 21.9, 0.37),
    ("dustpan", "carpet"): Table1Row(2629017, 2.5, 4, 6, 6.5, 0.21),
    ("eraser", "desk"): Table1Row(2003606, 4.6, 47, 48, 2.1, 0.50),
    ("fruit_basket", "wood"): Table1Row(1697917, 4.6, 7, 7, 0.3, 0.45),
    ("fruit_basket", "carpet"): Table1Row(1705726, 4.0, 7, 10, 0.4, 0.43),
    ("garlic", "wood"): Table1Row(876191, 4.5, 6, 6, 2.6, 0.24),
    ("keyboard", "carpet"): Table1Row(2366495, 5.9, 8, 9, 11.4, 0.30),
    ("lego_2x2", "desk"): Table1Row(4065133, 9.3, 9, 9, 16.3, 0.36),
    ("lego_2x4", "desk"): Table1Row(3994256, 8.0, 23, 23, 8.8, 0.41),
    ("metal_cup", "desk"): Table1Row(4252157, 12.8, 6, 6, 22.1, 0.32),
    ("metal_cup", "carpet"): Table1Row(2378823, 3.4, 9, 10, 3.3, 0.26),
    ("nut", "desk"): Table1Row(3790909, 8.3, 9, 10, 12.1, 0.33),
    ("paper_ball", "desk"): Table1Row(3160375, 4.6, 16, 20, 5.9, 0.24),
    ("plastic_container", "desk"): Table1Row(1797494, 4.8, 18, 22, 2.4, 0.32),
    ("plastic_spoon", "desk"): Table1Row(1115891, 4.6, 10, 15, 2.6, 0.38),
    ("tape_dispenser", "wood"): Table1Row(2726872, 6.4, 10, 10, 1.8, 0.41),
    ("tape_dispenser", "desk"): Table1Row(3561017, 7.9, 17, 17, 10.8, 0.36),
    ("wrench", "desk"): Table1Row(4862720, 15.7, 9, 11, 47.8, 0.17),
}


@dataclass(frozen=True)
class Table2Row:
    """A row of Table 2: errors of position of a motion. `longest_cm` is its L."""

    motion: str
    largest_cm: float
    largest_of_longest: float
    mean_cm: float
    mean_of_longest: float
    longest_cm: float


TABLE_2 = (
    Table2Row("Lego2x4 1", 6.0, 0.28, 3.7, 0.18, 21.3),
    Table2Row("Lego2x4 2", 7.4, 0.18, 4.1, 0.10, 41.1),
    Table2Row("Lego2x4 3", 2.8, 0.12, 1.9, 0.08, 24.0),
    Table2Row("Garlic 1", 8.3, 0.09, 4.4, 0.05, 96.8),
    Table2Row("Garlic 2", 4.1, 0.04, 2.4, 0.03, 96.7),
    Table2Row("TapeDispenser 1", 8.6, 0.12, 4.5, 0.06, 71.5),
    Table2Row("TapeDispenser 2", 10.0, 0.15, 5.8, 0.09, 64.8),
    Table2Row("TapeDispenser 3", 7.1, 0.18, 4.9, 0.12, 39.6),
)

FIGURE_16 = ("coat_hanger", "d6", "eraser", "lego_2x2")
