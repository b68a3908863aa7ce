"""The 36 features of BRISQUE: how the values of a displayed picture are distributed around their neighbors' mean.

From Mittal, Moorthy and Bovik, "No-Reference Image Quality Assessment in the Spatial Domain", IEEE Transactions on
Image Processing 21(12), 2012. `crates/metrics` computes the same in Rust; test_training.py and its own tests compare
both with one fixture. Where the paper leaves a choice: borders clip the window, whose weights still sum to 1; products
pair neighbors within the picture only; a pixel of the half-size picture is the mean of 2x2 pixels, and an odd last row
or column is dropped.
"""

import math

import numpy as np

LUMA = (0.2126, 0.7152, 0.0722)
RADIUS, SIGMA = 3, 7 / 6  # a window of 7x7 pixels
LEVELS = 255  # the range for which the paper's constant of 1 stabilizes the division
LEAST = 1e-6  # a smaller deviation is rounding, whose sign is meaningless, and counts of signs enter the features
SHAPES = (0.2, 10.0)  # the range of a distribution's shape: 1 is Laplace's, 2 is Gauss's
STEPS = 50  # of the bisection
SMALLEST = 2 * (2 * RADIUS + 1)  # the side at which the window fits into the half-size picture
PAIRS = (0, 1), (1, 0), (1, 1), (1, -1)  # neighbor's offset (down, right)


def features(shown):
    """The 36 features of display values [3,H,W] in 0..1. At full size, then at half size: shape and variance of the
    normalized values; then shape, mean, left and right variance of their products along rows, columns and both
    diagonals."""
    if min(shown.shape[1:]) < SMALLEST:
        raise ValueError(f"BRISQUE needs {SMALLEST}x{SMALLEST} pixels or more")
    luma = LEVELS * np.tensordot(LUMA, np.asarray(shown, np.float64), 1)
    return np.array([*_at_one_size(luma), *_at_one_size(_half(luma))])


def _half(plane):
    h, w = (side // 2 for side in plane.shape)
    return plane[:2 * h, :2 * w].reshape(h, 2, w, 2).mean((1, 3))


def _at_one_size(plane):
    m = normalized(plane)
    products = [asymmetric(_products(m, down, right)) for down, right in PAIRS]
    return [*symmetric(m), *(value for found in products for value in found)]


def normalized(plane):
    """The paper's MSCN coefficients, (I - mean) / (deviation + 1), with mean and deviation over a Gaussian window."""
    rows, columns = map(_windows, plane.shape)
    mean = rows @ plane @ columns.T
    variance = (rows @ plane**2 @ columns.T - mean**2).clip(0)
    away = plane - mean
    return np.where(abs(away) < LEAST, 0, away) / (np.sqrt(variance) + 1)


def _windows(side):
    """A row of weights for each position along a side; they sum to 1 even where the border clips the window."""
    distance = np.subtract.outer(np.arange(side), np.arange(side))
    weights = np.where(abs(distance) <= RADIUS, np.exp(-0.5 * (distance / SIGMA) ** 2), 0)
    return weights / weights.sum(1, keepdims=True)


def _products(m, down, right):
    """Each value times its neighbor, for pairs within the picture."""
    h, w = m.shape
    first, last = max(0, -right), w - max(0, right)
    return m[:h - down, first:last] * m[down:, first + right:last + right]


def symmetric(values):
    """Shape and variance of the generalized Gaussian that fits these values by moments: its shape follows from the
    ratio (E|x|)^2 / E x^2. For all zeros, the variance is 0 and the shape is the largest."""
    square = _mean_square(values)
    return (shape_of(_ratio(values)), square) if square else (SHAPES[1], 0.0)


def asymmetric(values):
    """Shape, mean, left and right variance of the asymmetric generalized Gaussian, fitted by moments: Lasmar, Stitou
    and Berthoumieu, "Multiscale skewed heavy tailed model for texture analysis", 2009. For all zeros, everything is 0
    except the shape, which is the largest."""
    left, right = (_mean_square(values[values * sign > 0]) for sign in (-1, 1))
    if left == right == 0:
        return SHAPES[1], 0.0, 0.0, 0.0
    skew = math.sqrt(min(left, right) / max(left, right))
    shape = shape_of(_ratio(values) * (skew**3 + 1) * (skew + 1) / (skew**2 + 1) ** 2)
    one, two, three = (math.lgamma(n / shape) for n in (1, 2, 3))
    mean = (math.sqrt(right) - math.sqrt(left)) * math.exp(two - (one + three) / 2)
    return shape, mean, left, right


def _ratio(values):
    return float(abs(values).mean()) ** 2 / _mean_square(values)


def _mean_square(values):
    return float((values**2).mean()) if values.size else 0.0


def shape_of(ratio):
    """The shape a with this ratio (E|x|)^2 / E x^2 = G(2/a)^2 / (G(1/a) G(3/a)), with the gamma function G; by
    bisection."""
    low, high = SHAPES
    for _ in range(STEPS):
        middle = (low + high) / 2
        one, two, three = (math.lgamma(n / middle) for n in (1, 2, 3))
        low, high = (middle, high) if math.exp(2 * two - one - three) < ratio else (low, middle)
    return (low + high) / 2
