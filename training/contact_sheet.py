"""Makes a contact sheet: each view's reference and noisiest render, and the reference's albedo and normal.

    pip install pillow
    python contact_sheet.py views sheet.png
    python contact_sheet.py views sheet.png --count 200 --tile 96 --columns 4

Color is exposed so that the reference's log-average luminance is middle gray.
"""

import argparse
from pathlib import Path

import torch
from PIL import Image, ImageDraw
from torch.nn import functional as F

from metrics import display, exposure_of
from views import read_view

GAP, LABEL = 4, 14  # pixels between strips; height of the label above each


def strip(view, tile):
    """The four images of a view side by side, [3,tile,4*tile] in 0..1."""
    reference, noisiest = view["ref"].float(), min(view["noisy"], key=lambda n: n[0])[1].float()
    exposure = exposure_of(reference[:3])
    images = [display(reference[:3] * exposure), display(noisiest[:3] * exposure),
              display(reference[3:6]), reference[6:9] / 2 + 0.5]
    return torch.cat([fit(image, tile) for image in images], 2)


def fit(image, tile):
    """The image scaled so that its longer side is `tile`, centered on a black square."""
    h, w = image.shape[1:]
    size = [max(1, round(side * tile / max(h, w))) for side in (h, w)]
    small = F.interpolate(image[None], size, mode="area")[0]
    top, left = (tile - size[0]) // 2, (tile - size[1]) // 2
    return F.pad(small, (left, tile - size[1] - left, top, tile - size[0] - top))


def label(view):
    samples = ", ".join(str(samples) for samples, _ in view["noisy"])
    return f"{view['name']}  {view['kind']}  samples {samples}  reference error {view['relerr']:.3f}"


def sheet(paths, tile, columns):
    """The strips of all views, row by row."""
    width, height = 4 * tile + GAP, tile + LABEL + GAP
    picture = Image.new("RGB", (columns * width, -(-len(paths) // columns) * height))
    draw = ImageDraw.Draw(picture)
    for i, path in enumerate(paths):
        view = read_view(path)
        x, y = i % columns * width, i // columns * height
        pixels = (strip(view, tile).permute(1, 2, 0) * 255).round().byte().numpy()
        picture.paste(Image.fromarray(pixels), (x, y + LABEL))
        draw.text((x, y), label(view), fill="white")
    return picture


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("views", type=Path, help="folder of views")
    p.add_argument("out", type=Path, help="image file to write")
    p.add_argument("--count", type=int, default=40, help="number of views, spread evenly over the folder")
    p.add_argument("--tile", type=int, default=192, help="size of each image in pixels")
    p.add_argument("--columns", type=int, default=2, help="views side by side")
    o = p.parse_args()
    paths = sorted(o.views.glob("*_v*.npz"))
    if not paths:
        raise SystemExit(f"{o.views}: no views (*_v*.npz)")
    count = min(o.count, len(paths))
    sheet([paths[i * len(paths) // count] for i in range(count)], o.tile, o.columns).save(o.out)
    print(f"{o.out}: {count} of {len(paths)} views")


if __name__ == "__main__":
    main()
