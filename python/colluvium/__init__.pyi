from .calibration import Calibration as Calibration
from .calibration import Objective as Objective
from .calibration import calibrate as calibrate
from .calibration import objective as objective
from .case import Case as Case
from .case import methods as methods
from .case import schema as schema
from .case import templates as templates
from .element_tests import ElementPath as ElementPath
from .element_tests import ElementTest as ElementTest
from .errors import CaseError as CaseError
from .errors import ColluviumWarning as ColluviumWarning
from .errors import OutputError as OutputError
from .errors import SolverError as SolverError
from .laws import law as law
from .rasters import draw_map as map
from .rasters import raster_outline as raster_outline
from .rasters import read_raster as read_raster
from .rasters import write_raster as write_raster
from .results import Dataset as Dataset
from .results import Frame as Frame
from .results import Points as Points
from .results import RunResult as RunResult
from .results import Safety as Safety
from .results import open_run as open_run
from .running import frames as frames
from .running import run as run
from .running import safety as safety
from .studies import Comparison as Comparison
from .studies import Sweep as Sweep
from .studies import compare as compare
from .studies import report as report
from .studies import sweep as sweep

__version__: str
__all__: list[str]
