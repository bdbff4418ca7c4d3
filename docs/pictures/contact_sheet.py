"""Show all films and figures of renders/gallery/ at once: contact_sheet_1.png, contact_sheet_2.png, ...

Of a film, its first frame and the one in the middle. Usage: make contact-sheet
       python docs/pictures/contact_sheet.py renders    # of the tracked pictures
"""

from __future__ import annotations

import re
import sys
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

RENDERS = Path(__file__).parents[2] / "renders"
FOLDER = RENDERS / "gallery"

CELL_WIDTH, LINE_HEIGHT, GAP = 270, 16, 8
"""Width of a picture, as in a row of three in the README, height of a line of its name, and distance of pictures, pixels."""
COLUMNS, MAX_SHEET_HEIGHT = 5, 1560
"""Number of pictures in a row, and largest height of a sheet (pixels): viewers scale larger sheets down."""
MAX_SHEET_SIZE = 3_000_000
"""Largest size of a sheet, bytes: a larger one takes long to send."""
PAPER, INK = (255, 255, 255), (40, 40, 40)
FONT = ImageFont.load_default(12)


def main() -> None:
    """Write the sheets into renders/gallery/."""
    FOLDER.mkdir(exist_ok=True)
    for old in FOLDER.glob("contact_sheet_*.png"):
        old.unlink()
    shown = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    paths = sorted(path for path in shown.iterdir() if path.suffix in (".gif", ".png"))
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
Row = Sequence[Picture]
"""At most COLUMNS pictures side by side."""


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


def split_into_sheets(pictures: Sequence[Picture]) -> list[list[Row]]:
    """Return the rows of each sheet: as few sheets as possible, of about the same height."""
    rows = [pictures[k : k + COLUMNS] for k in range(0, len(pictures), COLUMNS)]
    tallest = max(map(row_height, rows)) + GAP
    n_sheets = len(list(fill_sheets(rows, MAX_SHEET_HEIGHT)))
    # The less a sheet may hold, the more of them there are.
    heights = range(tallest, MAX_SHEET_HEIGHT + 1)
    lowest = bisect_left(heights, -n_sheets, key=lambda height: -len(list(fill_sheets(rows, height))))
    return list(fill_sheets(rows, heights[lowest]))


def fill_sheets(rows: Sequence[Row], max_height: int) -> Iterator[list[Row]]:
    """Yield the rows of each sheet, as many as fit into a height, pixels."""
    sheet: list[Row] = []
    height = GAP
    for row in rows:
        if sheet and height + row_height(row) > max_height:
            yield sheet
            sheet, height = [], GAP
        sheet.append(row)
        height += row_height(row)
    if sheet:
        yield sheet


def caption_lines(name: str) -> list[str]:
    """Return a name in lines that are not wider than a picture, broken where words end."""
    lines = [""]
    for word in re.findall(r"[^_ ]+[_ ]*|[_ ]+", name):
        if lines[-1] and FONT.getlength((lines[-1] + word).rstrip()) > CELL_WIDTH:
            lines.append("")
        lines[-1] += word
    return lines


def caption_height(row: Row) -> int:
    """Return the height of the names of a row, pixels."""
    return max(len(caption_lines(name)) for name, _ in row) * LINE_HEIGHT + 2


def row_height(row: Row) -> int:
    """Return the height of a row with its names and the gap below it, pixels."""
    return max(picture.height for _, picture in row) + caption_height(row) + GAP


def draw_sheet(rows: Sequence[Row]) -> Image.Image:
    """Return a sheet of rows of pictures, each under its name."""
    sheet = Image.new("RGB", (GAP + COLUMNS * (CELL_WIDTH + GAP), GAP + sum(map(row_height, rows))), PAPER)
    draw = ImageDraw.Draw(sheet)
    top = GAP
    for row in rows:
        picture_top = top + caption_height(row)
        for column, (name, picture) in enumerate(row):
            left = GAP + column * (CELL_WIDTH + GAP)
            lines = caption_lines(name)
            for number, line in enumerate(lines):
                # The last line stands next to the picture.
                draw.text((left, picture_top - 2 - (len(lines) - number) * LINE_HEIGHT), line, fill=INK, font=FONT)
            sheet.paste(picture, (left, picture_top))
        top += row_height(row)
    return sheet


if __name__ == "__main__":
    main()
