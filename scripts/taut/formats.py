"""Numbers as they are read: the same text in the figures, the HTML report and the terminal."""

import math

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NBSP = "\u00a0"
MINUS = "−"


def number(value: float, digits: int = 2, unit: str = "", plus: bool = False) -> str:
    """Returns a number with so many significant digits, as a power of ten where needed, and its unit."""
    if not math.isfinite(value):
        text = str(value)
    elif value == 0.0:
        text = "0"
    else:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        power = int(exponent)
        if -3 <= power < 6:
            text = f"{float(f'{mantissa}e{exponent}'):,.{max(digits - 1 - power, 0)}f}"
        else:
            text = f"{mantissa}{NBSP}×{NBSP}10{str(power).translate(_SUPERSCRIPTS)}"
    sign = "+" if plus and value > 0.0 else ""
    return sign + text.replace("-", MINUS) + (NBSP + unit if unit else "")


def count(value: int) -> str:
    """Returns a whole number with its thousands set apart."""
    return f"{value:,}"


def count_of(number: int, noun: str, plural: str = "") -> str:
    """Returns a number of things."""
    return f"{number} {noun}" if number == 1 else f"{number} {plural or noun + 's'}"


def percent(fraction: float, digits: int = 2) -> str:
    """Returns a fraction in percent."""
    return number(100.0 * fraction, digits, "%")


def energy_label(joules: float) -> str:
    """Returns an energy with the prefix that suits it, for the margin of a figure."""
    for scale, unit in ((1.0, "J"), (1e-3, "mJ"), (1e-6, "µJ"), (1e-9, "nJ")):
        if abs(joules) >= 0.9995 * scale:
            return f"{joules / scale:+.3g} {unit}".replace("-", MINUS)
    return "0"


def listed(items: list[str]) -> str:
    """Returns 'a', 'a and b' or 'a, b and c'."""
    return " and ".join(filter(None, [", ".join(items[:-1]), items[-1] if items else ""]))
