"""How far the body can be from where it is planned to be: the budget of tolerances, and what it takes of clearances."""
