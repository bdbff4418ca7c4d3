"""Show all films and figures of this folder at once: contact_sheet_1.png, contact_sheet_2.png, ...

Of a film, its first frame and the one in the middle. Usage: make contact-sheet
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

FOLDER = Path(__file__).parent

CELL_WIDTH, CAPTION_HEIGHT, GAP = 270, 18, 8
"""Width of a picture, as in a row of three in the README, height of its name, and distance of pictures, pixels."""
COLUMNS, MAX_SHEET_HEIGHT = 5, 1560
"""Number of pictures in a row, and largest height of a sheet (pixels): viewers scale larger sheets down."""
MAX_SHEET_SIZE = 3_000_000
"""Largest size of a sheet, bytes: a larger one takes long to send."""
PAPER, INK = (255, 255, 255), (40, 40, 40)


def main() -> None:
    """Write the sheets."""
    for old in FOLDER.glob("contact_sheet_*.png"):
        old.unlink()
    paths = sorted(path for path in FOLDER.iterdir() if path.suffix in (".gif", ".png"))
    pictures = [picture for path in paths for picture in read_pictures(path)]
    sizes = {}
    for number, rows in enumerate(split_into_sheets(pictures), start=1):
        target = FOLDER / f"contact_sheet_{number}.png"
        # 256 colours keep flat drawings as they are, in a third of the size.
        draw_sheet(rows).quantize(256).save(target, optimize=True)
        sizes[target.name] = target.stat().st_size
        print(f"{target.name}: {sizes[target.name] / 1000:.0f} kB")
    too_large = [name for name, size in sizes.items() if size > MAX_SHEET_SIZE]
    if too_large:
        raise SystemExit(f"larger than {MAX_SHEET_SIZE / 1e6:g} MB: {', '.join(too_large)}")


Picture = tuple[str, Image.Image]
"""Name and pixels, CELL_WIDTH wide."""


def read_pictures(path: Path) -> Iterator[Picture]:
    """Yield a figure, or the first frame of a film and that in its middle."""
    with Image.open(path) as image:
        n_frames = getattr(image, "n_frames", 1)
        size = f"{path.stat().st_size / 1000:.0f} kB"
        frames = [(0, f"{path.name}, {size}")] + ([(n_frames // 2, f"frame {n_frames // 2} of {n_frames}")] if n_frames > 1 else [])
        for frame, name in frames:
            image.seek(frame)
            yield name, flatten(image).resize((CELL_WIDTH, round(CELL_WIDTH * image.height / image.width)), Image.Resampling.LANCZOS)


def flatten(image: Image.Image) -> Image.Image:
    """Return a picture on paper, without transparency."""
    paper = Image.new("RGBA", image.size, (*PAPER, 255))
    paper.alpha_composite(image.convert("RGBA"))
    return paper.convert("RGB")


def split_into_sheets(pictures: Sequence[Picture]) -> Iterator[list[Sequence[Picture]]]:
    """Yield the rows of each sheet."""
    sheet: list[Sequence[Picture]] = []
    height = GAP
    for row in (pictures[k : k + COLUMNS] for k in range(0, len(pictures), COLUMNS)):
        if sheet and height + row_height(row) > MAX_SHEET_HEIGHT:
            yield sheet
            sheet, height = [], GAP
        sheet.append(row)
        height += row_height(row)
    if sheet:
        yield sheet


def row_height(row: Sequence[Picture]) -> int:
    """Return the height of a row with its names and the gap below it, pixels."""
    return max(picture.height for _, picture in row) + CAPTION_HEIGHT + GAP


def draw_sheet(rows: Sequence[Sequence[Picture]]) -> Image.Image:
    """Return a sheet of rows of pictures, each under its name."""
    sheet = Image.new("RGB", (GAP + COLUMNS * (CELL_WIDTH + GAP), GAP + sum(map(row_height, rows))), PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(12)
    top = GAP
    for row in rows:
        for column, (name, picture) in enumerate(row):
            left = GAP + column * (CELL_WIDTH + GAP)
            draw.text((left, top), name, fill=INK, font=font)
            sheet.paste(picture, (left, top + CAPTION_HEIGHT))
        top += row_height(row)
    return sheet


if __name__ == "__main__":
    main()
