# One entry to everything: `make help` lists the targets. The first call makes .venv with every version pinned.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DELETE_ON_ERROR:
.DEFAULT_GOAL := help
.PHONY: help run test test-parts test-whole check bench docs build clean venv

VENV := .venv
VENV_PYTHON := $(VENV)/bin/python
PACKAGES := swarm_msgs_py swarm_agent mission_computer swarm_sim
SOURCES := $(foreach package,$(PACKAGES),ros_ws/src/$(package))
MODULES := $(foreach package,$(PACKAGES),ros_ws/src/$(package)/$(package))

# A sourced ROS 2 Jazzy serves rclpy and the messages; otherwise they come as wheels from the package index.
ROS_HOME := $(if $(and $(filter jazzy,$(ROS_DISTRO)),$(AMENT_PREFIX_PATH)),system,wheels)
ifeq ($(ROS_HOME),system)
# The system's rclpy is compiled for the system's Python and for no other.
PYTHON_CANDIDATES := /usr/bin/python3 python3
VENV_FLAGS := --system-site-packages
REQUIREMENTS := requirements/base.txt requirements/dev.txt
else
PYTHON_CANDIDATES := python3.11 python3.12 python3
VENV_FLAGS :=
REQUIREMENTS := requirements/base.txt requirements/ros.txt requirements/dev.txt
endif
PYTHON ?= $(shell for python in $(PYTHON_CANDIDATES); do \
	"$$python" -c 'import ensurepip, sys; sys.exit(sys.version_info[:2] not in ((3, 11), (3, 12)))' 2>/dev/null \
	&& { echo "$$python"; break; }; done)
ARGS ?=

PIP := $(VENV_PYTHON) -m pip --quiet --quiet --no-input --disable-pip-version-check
INSTALLED := $(VENV)/.installed-$(ROS_HOME)
LINKED := $(VENV)/.linked-$(ROS_HOME)

# The same pytest plug-ins everywhere: a system ROS brings plug-ins of its own that newer pytest versions refuse.
export PYTEST_DISABLE_PLUGIN_AUTOLOAD := 1
export MPLBACKEND := Agg
PYTEST := $(VENV_PYTHON) -m pytest -p _hypothesis_pytestplugin

help: ## list the targets
	@grep -hE '^[a-z]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## (.*)/  make \1\t\2/' | expand -t 16
	@echo '  ARGS="..." passes arguments on, e.g. make run ARGS="--scenario formation-50 --seed 2"'
	@echo '  PYTHON=... names the interpreter that .venv is made with (3.11, or 3.12 with a C++ compiler)'

run: $(LINKED) ## run the demo: twelve robots form a shape (ARGS: see scripts/launch_swarm.py --help)
	@$(VENV_PYTHON) scripts/launch_swarm.py $(ARGS)

# Two streams side by side, because the suite is long: what takes a core, and what mostly waits for processes.
STREAM := --no-print-directory --jobs=2 $(if $(CI),--output-sync=target)

test: $(LINKED) ## run every test, or those that ARGS names
ifeq ($(strip $(ARGS)),)
	@$(MAKE) $(STREAM) test-parts test-whole
else
	@$(PYTEST) $(ARGS)
endif

test-parts:
	@$(PYTEST) --quiet tests/unit tests/property tests/contract tests/scenario $(wildcard tests/test_*.py)

test-whole:
	@$(PYTEST) --quiet tests/ros tests/system

check: $(LINKED) ## format, lint, types and the fast tests
	@$(VENV_PYTHON) -m ruff format --check .
	@$(VENV_PYTHON) -m ruff check .
	@$(VENV_PYTHON) -m mypy $(MODULES) scripts
	@$(PYTEST) --quiet $(wildcard tests/unit tests/property tests/contract) tests/test_*.py $(ARGS)

bench: $(LINKED) ## measure speed and quality of formation-50 on both engines, then single parts; prints tables
	@$(VENV_PYTHON) benchmarks/formation.py $(ARGS)
	@for part in benchmarks/bench_*.py; do echo; echo "### $$part"; PYTHONPATH=scripts $(VENV_PYTHON) "$$part"; done

docs: $(LINKED) ## build the documentation site into build/site
	@NO_MKDOCS_2_WARNING=1 $(VENV_PYTHON) -m mkdocs build --quiet --strict

build: $(LINKED) ## build the ROS workspace with colcon
	@cd ros_ws && PATH="$(abspath $(VENV))/bin:$$PATH" colcon build $(ARGS)

venv: $(LINKED) ## only install

clean: ## remove .venv, builds and caches; keeps runs/
	rm -rf $(VENV) ros_ws/build ros_ws/install ros_ws/log build .pytest_cache .mypy_cache .ruff_cache .hypothesis
	rm -rf ros_ws/src/*/build ros_ws/src/*/*.egg-info
	find . -name __pycache__ -type d -not -path './.git/*' -prune -exec rm -rf {} +

$(INSTALLED): requirements/build.txt $(REQUIREMENTS)
	@test -n "$(PYTHON)" || { echo "make: needs Python 3.11 or 3.12 with venv (Debian, Ubuntu: apt install python3-venv);" \
		"name it with PYTHON=..." >&2; exit 1; }
	@echo "Installing into $(VENV) ($$($(PYTHON) --version), ROS 2 Jazzy from $(ROS_HOME)); once, about two minutes ..."
	@rm -rf $(VENV)
	@"$(PYTHON)" -m venv $(VENV_FLAGS) $(VENV)
	@$(PIP) install --requirement requirements/build.txt
	@$(PIP) install --build-constraint requirements/build.txt $(addprefix --requirement ,$(REQUIREMENTS))
	@touch $@

# Links the four packages into .venv, so that an edit needs no new install; repeated when their metadata changes.
$(LINKED): $(INSTALLED) $(foreach source,$(SOURCES),$(source)/setup.py $(source)/setup.cfg)
	@PYTHONWARNINGS=ignore $(PIP) install --no-build-isolation --no-deps $(addprefix --editable ,$(SOURCES))
	@touch $@
