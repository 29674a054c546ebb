"""What commands exit with, and what is said of one that is interrupted."""

GOOD, NOT_FEASIBLE, WRONG_INPUT, FAULT, INTERRUPTED = 0, 1, 2, 70, 130

#: What is said when a command is interrupted and has nothing better to say.
INTERRUPTION = "interrupted; files written so far are whole"
