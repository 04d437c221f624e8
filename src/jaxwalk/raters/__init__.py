"""Ask people which of two cars drove more safely, and analyse what they answer."""

from jaxwalk.raters.answer_files import AnswersError, RaterFile, read_answers
from jaxwalk.raters.answer_words import answers_page
from jaxwalk.raters.answers_analysis import RatedDrivers, analyse
from jaxwalk.raters.rating_page import write_rating_page
from jaxwalk.raters.rating_plan import DriverMeasure, RatedPair, RatingError, RatingPlan, read_plan

__all__ = [
    "AnswersError",
    "DriverMeasure",
    "RatedDrivers",
    "RatedPair",
    "RaterFile",
    "RatingError",
    "RatingPlan",
    "analyse",
    "answers_page",
    "read_answers",
    "read_plan",
    "write_rating_page",
]
