# Each command does all of its own set-up on a machine with Python 3.11.
.PHONY: demo test docs clean

PYTHON_ENV := .venv/bin

demo: .venv/ready  ## three small apartments, from plan to segmented rooms, and a report
	$(PYTHON_ENV)/roomseg demo -o out/demo

test: .venv/ready  ## lint, types, site, tests and a wheel
	./check.sh

docs: .venv/ready  ## the pages as a site, in site/
	NO_MKDOCS_2_WARNING=1 $(PYTHON_ENV)/mkdocs build --strict

.venv/ready: setup.sh pyproject.toml constraints.txt
	./setup.sh

clean:
	rm -rf .venv dist build site out
