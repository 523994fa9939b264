"""Programs of controls drawn at random, with the path that each must give, reckoned as it is drawn."""

from drawn.iso import Fanuc, LinuxCnc
from drawn.klartext import Klartext
from drawn.siemens import Siemens
from drawn.writer import Writer

CONTROLS: dict[str, type[Writer]] = {"fanuc": Fanuc, "linuxcnc": LinuxCnc, "siemens": Siemens, "heidenhain": Klartext}
