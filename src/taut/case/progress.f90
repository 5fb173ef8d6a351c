!> A progress line on standard error, if that is a terminal.
module taut_case_progress
   use, intrinsic :: iso_fortran_env, only: error_unit, int64
   use taut_kinds, only: wp
   use taut_case_process, only: is_terminal
   implicit none (type, external)
   private
   public :: progress_t

   !> Time between two updates [s].
   real(wp), parameter :: interval = 0.2_wp

   !> One line that is written over and over.
   type :: progress_t
      logical, private :: active = .false., shown = .false.
      character(:), allocatable, private :: label
      integer(int64), private :: next = 0, ticks = 0
   contains
      procedure :: start
      procedure :: update
      procedure :: finish
   end type progress_t

contains

   !> Begins; nothing is shown before the first interval has passed.
   subroutine start(self, label, quiet)
      !> The line.
      class(progress_t), intent(inout) :: self
      !> What it is about.
      character(*), intent(in) :: label
      !> Whether nothing is to be shown.
      logical, intent(in) :: quiet
      integer(int64) :: now, rate

      self%label = label
      self%shown = .false.
      self%active = .not. quiet
      if (self%active) self%active = is_terminal()
      call system_clock(now, rate)
      self%ticks = int(interval*real(rate, wp), int64)
      self%next = now + self%ticks
   end subroutine start

   !> Shows how much is done, now and then.
   subroutine update(self, fraction)
      !> The line.
      class(progress_t), intent(inout) :: self
      !> Part done, from 0 to 1.
      real(wp), intent(in) :: fraction
      integer(int64) :: now

      if (.not. self%active) return
      call system_clock(now)
      if (now < self%next) return
      self%next = now + self%ticks
      self%shown = .true.
      write (error_unit, '(3a, i3, a)', advance='no') achar(13), self%label, ' ', nint(100.0_wp*fraction), ' %'
      flush (error_unit)
   end subroutine update

   !> Wipes the line.
   subroutine finish(self)
      !> The line.
      class(progress_t), intent(inout) :: self

      if (self%shown) write (error_unit, '(4a)', advance='no') achar(13), repeat(' ', len(self%label) + 8), achar(13)
      if (self%shown) flush (error_unit)
      self%shown = .false.
   end subroutine finish

end module taut_case_progress
