!> Which solver for which constraint matrix: by its name, or by what its factorization costs.
module taut_linalg_normal_solver_choose
   use taut_kinds, only: wp
   use taut_linalg_csr, only: csr_t
   use taut_linalg_normal_solver, only: normal_solver_t
   use taut_linalg_normal_solver_banded, only: banded_solver_t
   use taut_linalg_normal_solver_chain, only: are_chained, chain_solver_t
   use taut_linalg_normal_solver_dgelsd, only: dgelsd_solver_t, moore_penrose_solver_t
   use taut_linalg_normal_solver_factor, only: factor_solver_t
   use taut_linalg_normal_solver_pivoted, only: pivoted_solver_t
   use taut_linalg_normal_solver_scalar, only: scalar_solver_t
   use taut_linalg_normal_solver_sparse, only: sparse_solver_t
   implicit none (type, external)
   private
   public :: choose_solver, solver_names

   !> Names of solvers.
   !!
   !! `auto`: of an A with a pattern, banded or sparse where that pays; otherwise Cholesky with pivoting. `dgelsd`: by singular
   !! values of S. `factor`: by those of A L^-T, K = L L^T, which does not square the condition number. `pivoted-cholesky`: always
   !! that. `banded`, `sparse`: L D L^T in an ordering with a small bandwidth or with little fill.
   character(len=16), parameter :: solver_names(*) = [character(len=16) :: 'auto', 'dgelsd', 'factor', 'pivoted-cholesky', &
                                                      'banded', 'sparse']

   !> How much a multiplication of the sparse factorization costs, in those of the banded one, of the dense one, and of the
   !! dense one of so few constraints that it is done in loops as well.
   real(wp), parameter :: cost_over_banded = 3.0_wp, cost_over_dense = 4.0_wp, cost_over_small = 1.0_wp
   integer, parameter :: small = 48
   !> Up to so many constraints a dense factorization is faster than any other, unless S is tridiagonal.
   integer, parameter :: few = 6

contains

   !> Chooses a solver and sets it up; nothing is allocated afterwards.
   subroutine choose_solver(name, a, c, sizes, rcond, solver)
      !> One of `solver_names`, perhaps padded with blanks.
      character(*), intent(in) :: name
      !> A matrix with the pattern of A.
      type(csr_t), intent(in) :: a
      !> How many of its rows are used, from the first one on.
      integer, intent(in) :: c
      !> Sizes of the blocks of K.
      integer, intent(in) :: sizes(:)
      !> `dgelsd`: if not 0, the relative size below which singular values of S are zero, and not what is known of the rank, tells
      !! which count. Without effect on others.
      real(wp), intent(in) :: rcond
      !> The solver.
      class(normal_solver_t), allocatable, intent(out) :: solver

      select case (name)
      case ('dgelsd')
         if (rcond > 0.0_wp) then
            allocate (solver, source=new_moore_penrose(rcond))
         else
            allocate (dgelsd_solver_t :: solver)
         end if
      case ('factor')
         allocate (factor_solver_t :: solver)
      case ('banded')
         call allocate_banded(a, c, sizes, solver)
      case ('sparse')
         allocate (sparse_solver_t :: solver)
      case default
         if (a%full .and. c == 1) then
            allocate (scalar_solver_t :: solver)
         else if (a%full .or. name == 'pivoted-cholesky') then
            allocate (pivoted_solver_t :: solver)
         else
            call choose_by_cost(a, c, sizes, solver)
            return
         end if
      end select
      call solver%init(a, c, sizes)
   end subroutine choose_solver

   !> The Moore-Penrose inverse with a bound.
   function new_moore_penrose(rcond) result(solver)
      real(wp), intent(in) :: rcond
      type(moore_penrose_solver_t) :: solver

      solver%s_plus%rcond = rcond
   end function new_moore_penrose

   !> The solver for a small bandwidth, or that for a chain, which needs no other ordering.
   subroutine allocate_banded(a, c, sizes, solver)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: c, sizes(:)
      class(normal_solver_t), allocatable, intent(out) :: solver

      if (a%c == c .and. all(sizes == 1) .and. are_chained(a)) then
         allocate (chain_solver_t :: solver)
      else
         allocate (banded_solver_t :: solver)
      end if
   end subroutine allocate_banded

   !> Banded, sparse or dense for an A with a pattern.
   subroutine choose_by_cost(a, c, sizes, solver)
      type(csr_t), intent(in) :: a
      integer, intent(in) :: c, sizes(:)
      class(normal_solver_t), allocatable, intent(out) :: solver
      class(normal_solver_t), allocatable :: other
      real(wp) :: banded, sparse

      call allocate_banded(a, c, sizes, solver)
      call solver%init(a, c, sizes)
      select type (solver)
      class is (banded_solver_t)
         if (solver%band%width <= 1) return
         banded = solver%work()
      end select
      if (c > few) then
         allocate (sparse_solver_t :: other)
         call other%init(a, c, sizes)
         select type (other)
         class is (sparse_solver_t)
            sparse = other%work()
         end select
         if (merge(cost_over_small, cost_over_dense, c <= small)*min(sparse, banded/cost_over_banded) <= real(c, wp)**3/3) then
            if (banded >= cost_over_banded*sparse) call move_alloc(other, solver)
            return
         end if
      end if
      deallocate (solver)
      allocate (pivoted_solver_t :: solver)
      call solver%init(a, c, sizes)
   end subroutine choose_by_cost

end module taut_linalg_normal_solver_choose
