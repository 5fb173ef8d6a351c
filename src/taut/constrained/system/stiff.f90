!> What a stiff integrator may be told of a system besides: which forces depend on what, and which of them are stiff.
module taut_constrained_system_stiff
   use taut_kinds, only: wp
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_linalg_block_diagonal, only: block_diagonal_t
   implicit none (type, external)
   private
   public :: stiff_system_t

   !> A mechanical system with elastic rows: strains g(x), each with an internal force sigma that acts as -B^T sigma, B the
   !! derivative of the strains along the velocities or near to it, and sigma = k g with a constant stiffness k; with viscous
   !! damping of a time constant tau, sigma = k (g + tau gdot).
   !!
   !! An implicit integrator takes sigma as an unknown, so that its matrix stays valid while a stiff part turns and its step does
   !! not depend on the stiffness. All others see `force`, which contains -B^T sigma.
   type, abstract, extends(mechanical_system_t) :: stiff_system_t
      !> Number of elastic rows.
      integer :: n_elastic = 0
      !> Time constant of the damping of each row [s]: (n_elastic); not allocated for none.
      real(wp), allocatable :: elastic_damping(:)
   contains
      procedure :: coupling => everything_coupled
      procedure :: elastic_pattern => no_elastic_pattern
      procedure :: elastic_rows => no_elastic_rows
      procedure :: elastic_stiffness => no_elastic_stiffness
      procedure :: soft_force => all_force
   end type stiff_system_t

contains

   !> Which velocities have entries of `soft_force` that depend on which others and on their coordinates, apart from what
   !! constraints, elastic rows and masses couple; the default says nothing: all on all.
   subroutine everything_coupled(self, first, column)
      !> The system.
      class(stiff_system_t), intent(in) :: self
      !> First entry of each velocity in `column`, and the number of entries plus one at the end: (n + 1).
      integer, allocatable, intent(out) :: first(:)
      !> The others; a pair need be named once.
      integer, allocatable, intent(out) :: column(:)

      associate (unused_system => self, unused_first => first, unused_column => column)
      end associate
   end subroutine everything_coupled

   !> Where the entries of B are, row by row.
   subroutine no_elastic_pattern(self, first, column)
      !> The system.
      class(stiff_system_t), intent(in) :: self
      !> First entry of each row in `column`, and the number of entries plus one at the end: (n_elastic + 1).
      integer, allocatable, intent(out) :: first(:)
      !> Column of each entry, ascending within a row.
      integer, allocatable, intent(out) :: column(:)

      allocate (first(1), source=1)
      allocate (column(0))
      associate (unused_system => self)
      end associate
   end subroutine no_elastic_pattern

   !> The strains of the elastic rows, and B.
   subroutine no_elastic_rows(self, at, strain, values)
      !> The system.
      class(stiff_system_t), intent(in) :: self
      !> Where; v is used by damping only.
      type(state_t), intent(in) :: at
      !> Strains, those with damping plus their rates times its time constant: (n_elastic).
      real(wp), intent(out) :: strain(:)
      !> Entries of B in the order of the pattern.
      real(wp), intent(out) :: values(:)

      strain(:) = 0.0_wp
      values(:) = 0.0_wp
      associate (unused_system => self, unused_state => at)
      end associate
   end subroutine no_elastic_rows

   !> k, constant.
   subroutine no_elastic_stiffness(self, stiffness)
      !> The system.
      class(stiff_system_t), intent(in) :: self
      !> The blocks of k, to be laid out and filled; symmetric.
      type(block_diagonal_t), intent(inout) :: stiffness

      associate (unused_system => self, unused_stiffness => stiffness)
      end associate
   end subroutine no_elastic_stiffness

   !> f without what the elastic rows contribute.
   subroutine all_force(self, at, value)
      !> The system.
      class(stiff_system_t), intent(in) :: self
      !> The state at which it is evaluated.
      type(state_t), intent(in) :: at
      !> The force: (n).
      real(wp), intent(out) :: value(:)

      call self%force(at, value)
   end subroutine all_force

end module taut_constrained_system_stiff
